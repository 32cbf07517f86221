// What the test of a port does to the board from outside, and what it sees there.
//
// A bench may be a second board, wires from outputs to inputs of the same one, or, on a computer, a
// board that is made up (host/fake_board.cpp). What it cannot do it says by CANNOT or false; the
// promises that need it are then reported as not tested.
#pragma once

#include <stdint.h>

#include "../wax/src/port.h"

namespace bench {

const int32_t CANNOT = INT32_MIN;

// Microseconds by a clock that is not the port's; wraps at 2^32.
uint32_t now_us();

// Let time pass. The board's interrupts and timers go on, its program does not.
void wait_us(uint32_t us);

// Print a line.
void say(const char *line);

// Send bytes to the board at its bit rate, one after the other from now on.
bool send(const uint8_t *bytes, uint16_t size);

// Take what the board has sent since the last call, at most `size` bytes; return how many.
int32_t sent(uint8_t *bytes, uint16_t size);

// The power at a motor, from -wax::FULL_POWER to wax::FULL_POWER; 0 while it brakes or is off; CANNOT
// where there is no such motor.
int32_t motor(port::Wheel wheel);

// The next pulse that a servo has got since the last call; false if there is none.
struct Pulse {
    uint32_t began_us, width_us;
};
bool pulse(uint8_t axis, Pulse &seen);
bool sees_pulses();

// Turn the left and the right wheel from now on by so many ticks of their encoders, so many in a second.
bool turn(int32_t left, int32_t right, uint32_t per_s);

// Set the battery's input to so many thousandths of its full scale.
bool charge(uint16_t thousandths);

// Press the bumpers of these bits, and no others.
bool press(uint8_t bumpers);
uint8_t bumpers();  // all that there are

// How often the board has restarted by itself.
int32_t restarts();

// Let the program hang; return after how many microseconds the board restarted, or CANNOT. The time
// is `patience_us` where it did not. Tells whether the motors were off after that.
int32_t hang(uint32_t patience_us, bool &motors_off);

}  // namespace bench
