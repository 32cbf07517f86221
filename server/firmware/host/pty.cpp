#include "pty.h"

#include <fcntl.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

bool Pty::plug() {
    if (master_ >= 0) return true;
    master_ = posix_openpt(O_RDWR | O_NOCTTY);
    if (master_ < 0) return false;
    const char *name = grantpt(master_) == 0 && unlockpt(master_) == 0 ? ptsname(master_) : nullptr;
    if (name != nullptr) slave_ = open(name, O_RDWR | O_NOCTTY);
    termios raw;
    if (slave_ >= 0 && tcgetattr(slave_, &raw) == 0) {
        cfmakeraw(&raw);
        unlink(link_.c_str());
        if (tcsetattr(slave_, TCSANOW, &raw) == 0 && fcntl(master_, F_SETFL, O_NONBLOCK) == 0 &&
            symlink(name, link_.c_str()) == 0)
            return true;
    }
    unplug();
    return false;
}

void Pty::unplug() {
    if (master_ < 0) return;
    unlink(link_.c_str());
    if (slave_ >= 0) close(slave_);
    close(master_);
    master_ = slave_ = -1;
}

size_t Pty::read(uint8_t *bytes, size_t size) {
    if (master_ < 0) return 0;
    const ssize_t count = ::read(master_, bytes, size);
    return count > 0 ? static_cast<size_t>(count) : 0;
}

void Pty::write(const uint8_t *bytes, size_t size) {
    if (master_ >= 0 && ::write(master_, bytes, size) < 0) return;
}
