// wax-emulated-uno: the sketch as it is flashed, run by simavr's ATmega328P behind a pseudo-terminal.
//
// The instructions, timers, UART, ADC and watchdog are the chip's; its time is kept with ours.
#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <deque>
#include <string>

extern "C" {
#include <avr_adc.h>
#include <avr_ioport.h>
#include <avr_uart.h>
#include <sim_avr.h>
#include <sim_elf.h>
}

#include "log.h"
#include "pty.h"

namespace {

const char *const USAGE =
    "usage: wax-emulated-uno ELF LINK LOG\n"
    "\n"
    "LINK becomes a link to its serial port. LOG gets what its pins do, as JSON lines. Commands on\n"
    "the standard input, whose end ends it:\n"
    "  turn LEFT RIGHT PER_S  turn the wheels by so many ticks\n"
    "  battery MV             the voltage at A5\n"
    "  press PIN | release PIN of port B\n"
    "  unplug | plug | hang\n";

const uint32_t HZ = 16000000;
const uint32_t SLICE = HZ / 1000;

// Registers of the ATmega328P, by their addresses in memory.
const uint16_t PORT_B = 0x25, PORT_D = 0x2B, MODES_0 = 0x44, DUTY_A = 0x47, DUTY_B = 0x48;

double now_s() {
    timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

struct Wheel {
    char port_a, port_b;
    int a, b;
    bool is_high;
    long left;
    avr_cycle_count_t next, every;
};

class Uno {
public:
    Uno(const char *elf, const char *link, Log &log) : log_(log), cable_(link) {
        elf_firmware_t firmware = {};
        if (elf_read_firmware(elf, &firmware) != 0) exit(1);
        avr_ = avr_make_mcu_by_name("atmega328p");
        avr_init(avr_);
        avr_->log = LOG_ERROR;
        firmware.frequency = HZ;
        avr_load_firmware(avr_, &firmware);
        avr_->vcc = avr_->avcc = avr_->aref = 5000;

        uint32_t flags = 0;
        avr_ioctl(avr_, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
        hear_ = avr_io_getirq(avr_, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
        watch(AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT, [](avr_irq_t *, uint32_t value, void *me) {
            const uint8_t byte = static_cast<uint8_t>(value);
            static_cast<Uno *>(me)->cable_.write(&byte, 1);
        });
        watch(AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XON, [](avr_irq_t *, uint32_t, void *me) {
            static_cast<Uno *>(me)->may_hear_ = true;
        });
        watch(AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUT_XOFF, [](avr_irq_t *, uint32_t, void *me) {
            static_cast<Uno *>(me)->may_hear_ = false;
        });
        // The servo is on A2.
        watch(AVR_IOCTL_IOPORT_GETIRQ('C'), 2, [](avr_irq_t *, uint32_t value, void *me) {
            static_cast<Uno *>(me)->pulse(value != 0);
        });
        adc_ = avr_io_getirq(avr_, AVR_IOCTL_ADC_GETIRQ, ADC_IRQ_ADC5);
        set('B', 4, true);  // the bumpers, which are open
        set('C', 1, true);
        for (const Wheel &wheel : wheels_) set(wheel.port_a, wheel.a, false);
        plug();
    }

    void run() {
        const double began_s = now_s();
        avr_cycle_count_t until = 0;
        while (!ended_) {
            pollfd ends[] = {{STDIN_FILENO, POLLIN, 0}};
            const double ahead_s = static_cast<double>(until) / HZ - (now_s() - began_s);
            poll(ends, 1, ahead_s > 0.001 ? static_cast<int>(ahead_s * 1000.0) : 0);
            if (ends[0].revents != 0) read_commands();
            listen();
            for (until += SLICE; avr_->cycle < until;) step();
            look();
        }
    }

private:
    typedef void (*Seen)(avr_irq_t *, uint32_t, void *);

    avr_irq_t *pin(char port, int number) {
        return avr_io_getirq(avr_, AVR_IOCTL_IOPORT_GETIRQ(port), number);
    }

    // Set an input. The chip's pull-up would win again as soon as the program writes to its port.
    void set(char port, int number, bool high) {
        uint8_t &mask = masks_[port - 'B'], &values = values_[port - 'B'];
        const uint8_t bit = static_cast<uint8_t>(1 << number);
        mask = static_cast<uint8_t>(mask | bit);
        values = static_cast<uint8_t>(high ? values | bit : values & ~bit);
        avr_ioport_external_t held = {static_cast<unsigned char>(port & 0x7F), mask, values};
        avr_ioctl(avr_, AVR_IOCTL_IOPORT_SET_EXTERNAL(port), &held);
        avr_raise_irq(pin(port, number), high);
    }

    void watch(uint32_t device, int number, Seen seen) {
        avr_irq_register_notify(avr_io_getirq(avr_, device, number), seen, this);
    }

    void plug() {
        if (!cable_.plug()) exit(1);
        log_.say(now_s(), "plug");
    }

    void listen() {
        uint8_t bytes[256];
        const size_t count = cable_.read(bytes, sizeof bytes);
        heard_.insert(heard_.end(), bytes, bytes + count);
    }

    void step() {
        const uint16_t before = static_cast<uint16_t>(avr_->pc);
        const int state = avr_run(avr_);
        if (state == cpu_Done || state == cpu_Crashed) exit(1);
        if (hangs_ && avr_->pc == 0 && before != 0) {
            hangs_ = false;
            memcpy(avr_->flash + hung_at_, hung_, sizeof hung_);
            log_.say(now_s(), "restart", "\"after_ms\": %lu",
                     static_cast<unsigned long>((avr_->cycle - hung_cycle_) / (HZ / 1000)));
        }
        for (; may_hear_ && !heard_.empty(); heard_.pop_front()) avr_raise_irq(hear_, heard_.front());
        for (Wheel &wheel : wheels_)
            if (wheel.left != 0 && avr_->cycle >= wheel.next) {
                wheel.next += wheel.every / 2;
                wheel.is_high = !wheel.is_high;
                if (wheel.is_high) set(wheel.port_b, wheel.b, wheel.left > 0);
                set(wheel.port_a, wheel.a, wheel.is_high);
                if (!wheel.is_high) wheel.left -= wheel.left > 0 ? 1 : -1;
            }
    }

    void pulse(bool begins) {
        if (begins) {
            const avr_cycle_count_t since = avr_->cycle - pulsed_;
            apart_us_ = static_cast<unsigned>(since / (HZ / 1000000));
            pulsed_ = avr_->cycle;
        } else if (pulsed_ != 0) {
            log_.say(now_s(), "pulse", "\"us\": %u, \"apart_us\": %u",
                     static_cast<unsigned>((avr_->cycle - pulsed_) / (HZ / 1000000)), apart_us_);
        }
    }

    // What a motor gets: its PWM, or none where both of its bridge's inputs are alike.
    int power(uint8_t mode_bit, uint16_t duty, uint8_t pin_bit, bool ahead, bool back) const {
        if (ahead == back) return 0;
        const bool has_pwm = avr_->data[MODES_0] >> mode_bit & 1;
        const int size = has_pwm ? avr_->data[duty] : (avr_->data[PORT_D] >> pin_bit & 1) * 255;
        return ahead ? size : -size;
    }

    void look() {
        const uint8_t b = avr_->data[PORT_B], d = avr_->data[PORT_D];
        const int left = power(5, DUTY_B, 5, d >> 7 & 1, b & 1);
        const int right = power(7, DUTY_A, 6, b >> 1 & 1, b >> 2 & 1);
        if (left == left_ && right == right_) return;
        left_ = left;
        right_ = right;
        log_.say(now_s(), "motors", "\"left\": %d, \"right\": %d", left, right);
    }

    // Write a jump to itself where the program is.
    void hang() {
        hung_at_ = avr_->pc;
        hung_cycle_ = avr_->cycle;
        memcpy(hung_, avr_->flash + hung_at_, sizeof hung_);
        avr_->flash[hung_at_] = 0xFF;
        avr_->flash[hung_at_ + 1] = 0xCF;
        hangs_ = true;
    }

    void read_commands() {
        char letters[256];
        const ssize_t count = read(STDIN_FILENO, letters, sizeof letters);
        if (count <= 0) ended_ = true;
        for (ssize_t at = 0; at < count; ++at) {
            if (letters[at] != '\n') {
                command_ += letters[at];
                continue;
            }
            obey(command_.c_str());
            command_.clear();
        }
    }

    void obey(const char *command) {
        long left = 0, right = 0;
        unsigned value = 0;
        if (sscanf(command, "turn %ld %ld %u", &left, &right, &value) == 3) {
            const long ticks[] = {left, right};
            for (int at = 0; at < 2; ++at) {
                wheels_[at].left = ticks[at];
                wheels_[at].every = HZ / value;
                wheels_[at].next = avr_->cycle;
            }
        } else if (sscanf(command, "battery %u", &value) == 1) {
            avr_raise_irq(adc_, value);
        } else if (sscanf(command, "press %u", &value) == 1) {
            set('B', static_cast<int>(value), false);
        } else if (sscanf(command, "release %u", &value) == 1) {
            set('B', static_cast<int>(value), true);
        } else if (strcmp(command, "unplug") == 0) {
            cable_.unplug();
            log_.say(now_s(), "unplug");
        } else if (strcmp(command, "plug") == 0) {
            plug();
        } else if (strcmp(command, "hang") == 0) {
            log_.say(now_s(), "hang");
            hang();
        } else {
            fprintf(stderr, "wax-emulated-uno: there is no command '%s'\n%s", command, USAGE);
        }
    }

    Log &log_;
    Pty cable_;
    avr_t *avr_;
    avr_irq_t *hear_, *adc_;
    Wheel wheels_[2] = {{'D', 'D', 2, 4, false, 0, 0, 0},
                        {'D', 'B', 3, 3, false, 0, 0, 0}};  // as config.h has them
    uint8_t masks_[3] = {}, values_[3] = {};  // of the inputs of ports B, C and D
    std::deque<uint8_t> heard_;
    std::string command_;
    avr_cycle_count_t pulsed_ = 0, hung_cycle_ = 0;
    avr_flashaddr_t hung_at_ = 0;
    uint8_t hung_[2] = {};
    unsigned apart_us_ = 0;
    int left_ = 0, right_ = 0;
    bool may_hear_ = true, hangs_ = false, ended_ = false;
};

}  // namespace

int main(int count, char **words) {
    if (count != 4) {
        fputs(USAGE, stderr);
        return 2;
    }
    FILE *file = fopen(words[3], "a");
    if (file == nullptr) {
        fprintf(stderr, "wax-emulated-uno: %s: %s\n", words[3], strerror(errno));
        return 1;
    }
    signal(SIGPIPE, SIG_IGN);
    Log log(file);
    Uno(words[1], words[2], log).run();
    return 0;
}
