// The settings of a robot; change nothing elsewhere. Pin numbers are those of an Arduino Uno or
// Nano (A0 is 14); unconnected pins do no harm unless a comment says so.
#pragma once

#include <stdint.h>

#include "src/core/base.h"
#include "src/core/body.h"
#include "src/core/robot.h"

namespace config {

const uint8_t NONE = 255;

// Bits a second; [robot.serial] baud must be the same.
const uint32_t BAUD = 115200;

// --- motors: a dual H-bridge with a PWM and two direction inputs each, such as L298N or TB6612.
// Solder 10 kOhm from each PWM input to ground: while the board restarts its pins float.
const uint8_t LEFT_PWM = 5, LEFT_A = 7, LEFT_B = 8;
const uint8_t RIGHT_PWM = 6, RIGHT_A = 9, RIGHT_B = 10;
// A base that moves sideways has one or two motors more. On an Uno pins 3, 16, 17 and 11, 2, 4 are
// free for them if the encoders are NONE.
const uint8_t BACK_PWM = NONE, BACK_A = NONE, BACK_B = NONE;  // of three; the back left of four
const uint8_t BACK_RIGHT_PWM = NONE, BACK_RIGHT_A = NONE, BACK_RIGHT_B = NONE;
const uint8_t STANDBY = NONE;  // STBY of a TB6612; NONE if it is wired to its supply

// mm/s of a wheel at full PWM, measured on the floor; and the PWM (of 255) at which it just turns.
const int16_t FULL_SPEED_MMPS = 800;
const uint8_t LEAST_PWM = 40;

// --- the base: wax::Kind::SIDES, MECANUM (four wheels, LEFT and RIGHT are in front) or OMNI (three,
// one at the back), as src/core/base.h describes them; [robot] must say the same, in metres: base,
// and wheel_base_m, axle_base_m or omni_radius_m.
const wax::Kind BASE = wax::Kind::SIDES;
const uint16_t TRACK_MM = 200, AXLES_MM = 200;  // MECANUM: from left to right, and front to back
const uint16_t RADIUS_MM = 120;                 // OMNI: from the middle to each wheel

// --- encoders: A on the two interrupt pins, B gives the direction; or NONE.
const uint8_t LEFT_ENCODER_A = 2, LEFT_ENCODER_B = 4;
const uint8_t RIGHT_ENCODER_A = 3, RIGHT_ENCODER_B = 11;

// --- bumpers: switches to ground, one bit each from bit 0. Not pin 13: a Nano's LED pulls it down,
// like a bumper that is always pressed.
const uint8_t BUMPERS = 2;
const uint8_t BUMPER_PINS[BUMPERS] = {12, 15};

// --- battery: through two resistors to an analog pin, or NONE; mV at full scale.
const uint8_t BATTERY_PIN = NONE;
const uint16_t BATTERY_FULL_SCALE_MV = 15000;

const wax::Body BODY = {FULL_SPEED_MMPS, LEAST_PWM, BATTERY_FULL_SCALE_MV};

// --- servos of the axes, in the order of [robot.serial] axes: the pin of each, or NONE. Give them a
// supply of their own; what they draw when they start restarts a board that feeds them. With servos
// pins 9 and 10 have no PWM.
constexpr uint8_t SERVO_PINS[wax::AXES] = {NONE, NONE, NONE, NONE};

// --- motion. The server limits acceleration too; these are the limits of the robot's body. Braking
// applies to every stop: 20000 is 30 ms from 0.6 m/s. Use less only for a robot that would fall
// over, and set [robot] braking_mps2 to match. A base that moves sideways has them in any direction
// as a whole: of mecanum wheels two change up to 1.41 times as fast.
const wax::Settings SETTINGS = {
    2500,   // acceleration_mmps2, 1 to 65535
    20000,  // braking_mmps2, 1 to 65535
    0x01,   // front_bumpers: these bits block forward motion
    0x02,   // back_bumpers: these block backward motion
    50,     // still_ms: a wheel without an encoder tick for this long stands
    {
        // Each servo: its pulses in microseconds at -1 and at 1, swapped for one that turns the
        // wrong way, and the most that they change in a second.
        {1000, 2000, 2000},
        {1000, 2000, 2000},
        {1000, 2000, 2000},
        {1000, 2000, 2000},
    },
    {
        BASE,
        BASE == wax::Kind::OMNI ? RADIUS_MM : (TRACK_MM + AXLES_MM) / 2,
        FULL_SPEED_MMPS,
        0x00,  // left_bumpers: these bits block motion to the left
        0x00,  // right_bumpers: these bits block motion to the right
    },
};

}  // namespace config
