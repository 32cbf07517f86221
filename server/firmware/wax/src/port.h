// What a board must do for `program.h`: a port writes these functions and calls its loop.
//
// wax.ino is the port for AVR boards; PORTING.md says how to write one for an ESP32, an RP2040 or
// another, and how to put these promises to the test. What a promise says in figures, the test
// measures. All functions are called from one loop, never from an interrupt, and none waits: all but
// `begin` and `noise` return within CALL_US.
#pragma once

#include <stdint.h>

#include "core/power.h"
#include "core/robot.h"

namespace port {

// The order is that of `wax::Kind`; a board has the wheels of its base.
enum Wheel : uint8_t { LEFT = 0, RIGHT = 1, BACK_LEFT = 2, BACK_RIGHT = 3, BACK = 2 };

const uint16_t CALL_US = 200;
const uint16_t CLOCK_STEP_MS = 2;
const uint16_t CLOCK_ERROR_PERCENT = 2;
const uint16_t MOTOR_WITHIN_MS = 5;
const uint16_t SERVO_EVERY_MS = 20;
const uint16_t SERVO_ERROR_US = 15;
const uint16_t SERVO_WITHIN_MS = 50;
const uint16_t RECEIVES_AT_LEAST = 63;
const uint16_t REPORT_SENT_MS = 10;
const uint16_t WATCHDOG_LEAST_MS = 20, WATCHDOG_MOST_MS = 250;
const uint16_t TICKS_PER_S = 5000;
const uint16_t BATTERY_FULL_SCALE_MOST = 4095;
const uint8_t BATTERY_ERROR_PERCENT = 3;

// Prepare everything. Before it, while the board starts and restarts, the motors have no power and
// the servos no pulse, by hardware where a pin would float. The watchdog runs from here on.
void begin();

// --- the clock ---

// Milliseconds since any moment. It never goes back but at 2^32, where it begins at 0 again, steps
// by CLOCK_STEP_MS at most while it is read all the time, and is wrong by CLOCK_ERROR_PERCENT at
// most: by this clock the robot stops itself. Neither serial data nor encoders hold it up.
uint32_t now_ms();

// A number that differs from one start to the next with 15 of 16 bits' chance at least, such as an
// ADC's or a ring oscillator's noise: frames from before a restart must be stale after it.
uint32_t noise();

// --- the serial line ---

// Take the oldest byte that has come; false if there is none. While nobody takes them, at least
// RECEIVES_AT_LEAST bytes are kept, the oldest ones, in their order.
bool read(uint8_t &byte);

// How many bytes `write` takes now: wax::REPORT_SIZE at least, once nothing was sent for
// REPORT_SENT_MS.
uint16_t room();

// Send bytes, no more than there is room for, whole and in their order.
void write(const uint8_t *bytes, uint8_t size);

// --- the motors ---

// Give a motor power from -wax::FULL_POWER to wax::FULL_POWER, positive as `wax::Kind` says, within
// MOTOR_WITHIN_MS; it holds until the next call. At 0 it brakes, which shorts the motor.
// A motor that the board does not have is ignored.
void motor(Wheel wheel, int16_t power);

// --- the servos ---

// Give a servo a pulse of this width every SERVO_EVERY_MS, within SERVO_WITHIN_MS from the call and
// wrong by SERVO_ERROR_US at most, or none at all at 0. Never a pulse of another width in between.
// Axes without a servo ignore it.
void servo(uint8_t axis, uint16_t pulse_us);

// --- what the board feels ---

// The battery as a number from 0 to battery_full_scale(), in proportion to its voltage and wrong by
// BATTERY_ERROR_PERCENT of it at most; always 0 where it is not measured.
uint16_t battery();
uint16_t battery_full_scale();  // at most BATTERY_FULL_SCALE_MOST

// The pressed bumpers, one bit each; contacts may bounce.
uint8_t bumpers();

// What the encoder of the left or right wheel has counted since the start, forward positive, wraps
// at 2^32. At TICKS_PER_S on both wheels at once, with serial data coming, none is lost and none is
// made up. It is asked about these two wheels only.
int32_t ticks(Wheel wheel);

// --- the watchdog ---

// Say that the loop lives. If it is not said for WATCHDOG_MOST_MS the board restarts, by hardware,
// with the motors without power; said every WATCHDOG_LEAST_MS it never does.
void feed_watchdog();

}  // namespace port
