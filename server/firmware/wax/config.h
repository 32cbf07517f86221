// What is particular to a robot: change it here, and nothing elsewhere. Pins are numbers of an
// Arduino Uno or Nano (A0 is 14); what is not connected does no harm where no remark says so.
#pragma once

#include <stdint.h>

#include "src/core/robot.h"

namespace config {

const uint8_t NONE = 255;

// Bits a second; [robot.serial] baud must be the same.
const uint32_t BAUD = 115200;

// --- motors: a dual H-bridge with a PWM and two direction inputs each, such as L298N or TB6612.
// Solder 10 kOhm from each PWM input to ground: while the board restarts its pins are in the air.
const uint8_t LEFT_PWM = 5, LEFT_A = 7, LEFT_B = 8;
const uint8_t RIGHT_PWM = 6, RIGHT_A = 9, RIGHT_B = 10;
const uint8_t STANDBY = NONE;  // STBY of a TB6612; NONE where it is wired to its supply

// mm/s of a wheel at full PWM, measured on the floor; and the PWM, of 255, at which it just turns.
const int16_t FULL_SPEED_MMPS = 800;
const uint8_t LEAST_PWM = 40;

// --- encoders: A on the two pins with an interrupt, B says which way.
const uint8_t LEFT_ENCODER_A = 2, LEFT_ENCODER_B = 4;
const uint8_t RIGHT_ENCODER_A = 3, RIGHT_ENCODER_B = 11;

// --- bumpers: switches to ground, one bit each from bit 0. Not pin 13: on a Nano its LED pulls it
// down, which would be a bumper that is always pressed.
const uint8_t BUMPERS = 2;
const uint8_t BUMPER_PINS[BUMPERS] = {12, 15};

// --- battery: by two resistors to an analog pin, NONE without; mV that read as full scale.
const uint8_t BATTERY_PIN = NONE;
const uint16_t BATTERY_FULL_SCALE_MV = 15000;

// --- motion. The server limits acceleration too; this is what the body bears whatever it is told.
// Braking is for every stop: 20000 is 30 ms from 0.6 m/s. Less only for a body that would fall
// over, and then [robot] braking_mps2 must say so.
const wax::Settings SETTINGS = {
    2500,   // acceleration_mmps2, 1 to 65535
    20000,  // braking_mmps2, 1 to 65535
    0x01,   // front_bumpers: while one of these bits is set it does not go ahead
    0x02,   // back_bumpers: nor back
    50,     // still_ms: without an encoder's tick for so long it stands
};

}  // namespace config
