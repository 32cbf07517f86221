// A pseudo-terminal that can be unplugged, behind a name of our own.
#pragma once

#include <stddef.h>
#include <stdint.h>

#include <string>

class Pty {
public:
    // `link` becomes a symbolic link to the terminal while it is plugged in.
    explicit Pty(const std::string &link) : link_(link) {}
    ~Pty() { unplug(); }
    Pty(const Pty &) = delete;
    Pty &operator=(const Pty &) = delete;

    // Both are safe to call twice. `plug` returns false, and errno why, where none is to be had.
    bool plug();
    void unplug();

    // To poll for bytes; -1 while unplugged.
    int descriptor() const { return master_; }

    // What has come, at most `size`; 0 if nothing.
    size_t read(uint8_t *bytes, size_t size);

    // Write what there is room for; a board does not wait for who does not listen.
    void write(const uint8_t *bytes, size_t size);

private:
    std::string link_;
    int master_ = -1;
    int slave_ = -1;  // kept open: without it reading fails until somebody opens the terminal
};
