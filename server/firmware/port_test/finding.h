// What a promise's test finds, and what all of them need.
#pragma once

#include <stdint.h>

namespace port_test {

const uint32_t MS = 1000;

// What is wrong, or nullptr.
typedef const char *Finding;
extern const char NOT_TESTED[];

Finding wrong(const char *what, int32_t found, int32_t wanted);

int32_t distance(int32_t a, int32_t b);

// Microseconds by the bench's clock.
uint32_t since(uint32_t began_us);

// Let time pass for a program that lives.
void pass(uint32_t us);

// Let the line become quiet, and forget what came and what was sent.
void drain();

// Expect these powers; of the back motors only where there are some.
Finding expect_motors(int16_t left, int16_t right, int16_t back_left = 0, int16_t back_right = 0);

// --- the promises ---

Finding motors_are_off_at_first();
Finding servos_are_still_at_first();
Finding clock_goes_on();
Finding clock_goes_on_under_load();
Finding noise_differs();
Finding nothing_waits();
Finding bytes_are_kept_in_order();
Finding reports_are_sent_whole();
Finding motors_follow();
Finding motors_hold();
Finding servos_follow();
Finding servos_do_not_twitch();
Finding battery_is_in_proportion();
Finding bumpers_are_felt();
Finding ticks_are_counted();
Finding a_living_program_is_left_alone();
Finding the_program_drives_and_stops();
Finding the_program_moves_sideways_and_stops();
Finding a_program_that_hangs_is_restarted();

}  // namespace port_test
