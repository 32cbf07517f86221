// A board that is made up, on a clock of its own: a port and its bench at once.
#pragma once

namespace fake {

// What is wrong with it, each breaking one promise of `port.h`.
extern const char *const FAULTS[];
extern const unsigned FAULT_COUNT;

// Let it have a fault of these; false if there is no such.
bool break_it(const char *name);

// Let its bench see and do nothing.
void blind_it();

}  // namespace fake
