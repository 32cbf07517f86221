// The promises of `port.h`, put to the test on any board.
#pragma once

#include <stdint.h>

namespace port_test {

// Test all promises and print a line for each by `bench::say`; return how many were broken. Call it
// once, before `port::begin`.
uint16_t run();

}  // namespace port_test
