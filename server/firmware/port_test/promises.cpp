#include "promises.h"

#include <stdio.h>

#include "bench.h"
#include "finding.h"

namespace port_test {

namespace {

struct Promise {
    const char *name;
    Finding (*test)();
};

const Promise PROMISES[] = {
    {"the motors are off at first", motors_are_off_at_first},
    {"the servos have no pulse at first", servos_are_still_at_first},
    {"the clock goes on", clock_goes_on},
    {"the clock goes on under load", clock_goes_on_under_load},
    {"noise differs", noise_differs},
    {"no call waits", nothing_waits},
    {"bytes are kept in their order", bytes_are_kept_in_order},
    {"reports are sent whole", reports_are_sent_whole},
    {"motors follow", motors_follow},
    {"motors hold", motors_hold},
    {"servos follow", servos_follow},
    {"servos do not twitch", servos_do_not_twitch},
    {"the battery is in proportion", battery_is_in_proportion},
    {"bumpers are felt", bumpers_are_felt},
    {"ticks are counted", ticks_are_counted},
    {"a living program is left alone", a_living_program_is_left_alone},
    {"the program drives and stops", the_program_drives_and_stops},
    {"the program moves sideways and stops", the_program_moves_sideways_and_stops},
    {"a program that hangs is restarted", a_program_that_hangs_is_restarted},
};

}  // namespace

uint16_t run() {
    uint16_t broken = 0;
    port::begin();
    for (const Promise &promise : PROMISES) {
        const Finding found = promise.test();
        char line[160];
        if (found == nullptr)
            snprintf(line, sizeof line, "ok - %s", promise.name);
        else if (found == NOT_TESTED)
            snprintf(line, sizeof line, "not tested - %s: the bench cannot", promise.name);
        else
            snprintf(line, sizeof line, "BROKEN - %s: %s", promise.name, found);
        bench::say(line);
        broken = static_cast<uint16_t>(broken + (found != nullptr && found != NOT_TESTED));
    }
    return broken;
}

}  // namespace port_test
