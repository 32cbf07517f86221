// wax-board: the firmware's core on this machine, behind a pseudo-terminal.
#include <errno.h>
#include <getopt.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <memory>
#include <string>

#include "board.h"
#include "log.h"
#include "pty.h"

namespace {

const char *const USAGE =
    "usage: wax-board --link PATH [--log FILE] [--boot-ms N] [--base KIND] [--unplugged]\n"
    "\n"
    "PATH becomes a link to the serial port. FILE gets what the board does, as JSON lines.\n"
    "KIND is differential (if not given), mecanum or omni.\n"
    "Commands on the standard input, whose end ends it:\n"
    "  unplug | plug          pull the cable, or put it back; the board lives on\n"
    "  reset                  restart the board; for --boot-ms it neither hears nor speaks\n"
    "  bumper N | battery MV  press the bumpers of these bits; charge the battery\n"
    "  mute on | mute off     say nothing\n"
    "  deaf on | deaf off     hear nothing\n"
    "  quit\n";

volatile sig_atomic_t asked_to_end = 0;

void end_soon(int) { asked_to_end = 1; }

double now_s() {
    timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

struct Options {
    std::string link, log = "/dev/stdout";
    uint32_t boot_ms = 0;
    wax::Kind kind = wax::Kind::SIDES;
    bool plugged = true;
};

bool read_kind(const std::string &word, wax::Kind &kind) {
    if (word == "mecanum") kind = wax::Kind::MECANUM;
    if (word == "omni") kind = wax::Kind::OMNI;
    return kind != wax::Kind::SIDES || word == "differential";
}

bool read_options(int count, char **words, Options &options) {
    const option known[] = {{"link", required_argument, nullptr, 'l'},
                            {"log", required_argument, nullptr, 'o'},
                            {"boot-ms", required_argument, nullptr, 'b'},
                            {"base", required_argument, nullptr, 'k'},
                            {"unplugged", no_argument, nullptr, 'u'},
                            {nullptr, 0, nullptr, 0}};
    int which;
    while ((which = getopt_long(count, words, "", known, nullptr)) != -1) {
        switch (which) {
            case 'l': options.link = optarg; break;
            case 'o': options.log = optarg; break;
            case 'b': options.boot_ms = static_cast<uint32_t>(strtoul(optarg, nullptr, 10)); break;
            case 'k':
                if (!read_kind(optarg, options.kind)) return false;
                break;
            case 'u': options.plugged = false; break;
            default: return false;
        }
    }
    return !options.link.empty() && optind == count;
}

// The board, its cable and who commands both.
class Bench {
public:
    Bench(const Options &options, Log &log)
        : log_(log), cable_(options.link), board_(log, options.boot_ms, options.kind, now_s()) {
        if (options.plugged) plug();
    }

    void run() {
        while (!asked_to_end && !ended_) {
            pollfd ends[] = {{STDIN_FILENO, POLLIN, 0}, {cable_.descriptor(), POLLIN, 0}};
            poll(ends, 2, 1);
            if (ends[0].revents != 0) read_commands();
            uint8_t bytes[256];
            const size_t count = cable_.read(bytes, sizeof bytes);
            const double t_s = now_s();
            if (!deaf_) board_.hear(bytes, count, t_s);
            board_.tick(t_s);
            if (board_.report(t_s, bytes) && !mute_) cable_.write(bytes, wax::REPORT_SIZE);
        }
    }

private:
    void plug() {
        if (cable_.plug()) {
            log_.say(now_s(), "plugged");
        } else {
            fprintf(stderr, "wax-board: there is no pseudo-terminal (%s)\n", strerror(errno));
            ended_ = true;
        }
    }

    void read_commands() {
        char text[256];
        const ssize_t count = read(STDIN_FILENO, text, sizeof text);
        if (count <= 0) ended_ = true;
        for (ssize_t at = 0; at < count; ++at) {
            if (text[at] != '\n') {
                command_ += text[at];
                continue;
            }
            obey(command_);
            command_.clear();
        }
    }

    void obey(const std::string &command) {
        unsigned value = 0;
        if (command == "unplug") {
            cable_.unplug();
            log_.say(now_s(), "unplugged");
        } else if (command == "plug") {
            plug();
        } else if (command == "reset") {
            board_.reset(now_s());
        } else if (command == "quit") {
            ended_ = true;
        } else if (command == "mute on" || command == "mute off") {
            mute_ = command == "mute on";
        } else if (command == "deaf on" || command == "deaf off") {
            deaf_ = command == "deaf on";
        } else if (sscanf(command.c_str(), "bumper %u", &value) == 1) {
            board_.press(static_cast<uint8_t>(value));
        } else if (sscanf(command.c_str(), "battery %u", &value) == 1) {
            board_.charge(static_cast<uint16_t>(value));
        } else {
            fprintf(stderr, "wax-board: there is no command '%s'\n%s", command.c_str(), USAGE);
        }
    }

    Log &log_;
    Pty cable_;
    Board board_;
    std::string command_;
    bool mute_ = false, deaf_ = false, ended_ = false;
};

}  // namespace

int main(int count, char **words) {
    Options options;
    if (!read_options(count, words, options)) {
        fputs(USAGE, stderr);
        return 2;
    }
    FILE *file = fopen(options.log.c_str(), "a");
    if (file == nullptr) {
        fprintf(stderr, "wax-board: %s: %s\n", options.log.c_str(), strerror(errno));
        return 1;
    }
    signal(SIGTERM, end_soon);
    signal(SIGINT, end_soon);
    signal(SIGPIPE, SIG_IGN);
    Log log(file);
    Bench(options, log).run();
    fclose(file);
    return 0;
}
