// WAX on an Arduino Uno, Nano or similar: serial frames in, two motors out. Settings of a robot are
// in config.h; everything that decides about motion is in src/core, which WAX's tests also run.
//
// Axes have no motor here: `robot.axis(0)` to `robot.axis(3)` return the targets for yours.

#if defined(__AVR__)
#include <avr/wdt.h>
#endif

#include "config.h"
#include "src/core/crc16.h"
#include "src/core/robot.h"

namespace {

const uint8_t BYTES_A_ROUND = 32;
const uint8_t BATTERY_EVERY_MS = 100;

uint32_t origin_ms;
wax::Robot *robot;

volatile int32_t left_ticks, right_ticks;

void left_encoder() {
    left_ticks += digitalRead(config::LEFT_ENCODER_B) ? 1 : -1;
}

void right_encoder() {
    right_ticks += digitalRead(config::RIGHT_ENCODER_B) ? 1 : -1;
}

uint32_t now_ms() {
    return millis() + origin_ms;
}

// The clock starts at a random time, so that frames from before a restart are stale after it.
uint32_t somewhere() {
    uint8_t noise[32];
    for (uint8_t &octet : noise)
        octet = static_cast<uint8_t>(analogRead(A0) + (analogRead(A5) << 4) + micros());
    return static_cast<uint32_t>(wax::crc16(noise, sizeof noise, 0)) << 16 |
           wax::crc16(noise, sizeof noise / 2, 0);
}

// At 0 both outputs of the bridge are equal, which brakes.
void drive(uint8_t pwm, uint8_t a, uint8_t b, int16_t mmps) {
    const int32_t size = mmps < 0 ? -static_cast<int32_t>(mmps) : mmps;
    const int32_t share = (255 - config::LEAST_PWM) * size / config::FULL_SPEED_MMPS;
    digitalWrite(a, mmps >= 0);
    digitalWrite(b, mmps <= 0);
    analogWrite(pwm, mmps == 0 || share > 255 - config::LEAST_PWM
                         ? 255
                         : static_cast<int>(config::LEAST_PWM + share));
}

uint16_t battery_mv() {
    static uint16_t last_mv;
    static uint32_t measured_ms;
    if (config::BATTERY_PIN != config::NONE && millis() - measured_ms >= BATTERY_EVERY_MS) {
        measured_ms = millis();
        last_mv = static_cast<uint16_t>(static_cast<uint32_t>(analogRead(config::BATTERY_PIN)) *
                                        config::BATTERY_FULL_SCALE_MV / 1023);
    }
    return last_mv;
}

wax::Inputs inputs() {
    wax::Inputs now = wax::Inputs();
    now.battery_mv = battery_mv();
    for (uint8_t at = 0; at < config::BUMPERS; ++at)
        if (!digitalRead(config::BUMPER_PINS[at]))
            now.bumpers = static_cast<uint8_t>(now.bumpers | 1 << at);
    noInterrupts();
    now.left_ticks = left_ticks;
    now.right_ticks = right_ticks;
    interrupts();
    return now;
}

}  // namespace

void setup() {
#if defined(__AVR__)
    // A program that hangs restarts, with the motors off. The bootloader of Nanos from before 2018
    // then restarts for ever: install Optiboot on such a board.
    wdt_enable(WDTO_60MS);
#endif
    const uint8_t outputs[] = {config::LEFT_PWM,  config::LEFT_A,  config::LEFT_B,
                               config::RIGHT_PWM, config::RIGHT_A, config::RIGHT_B};
    for (const uint8_t pin : outputs) pinMode(pin, OUTPUT);
    if (config::STANDBY != config::NONE) {
        pinMode(config::STANDBY, OUTPUT);
        digitalWrite(config::STANDBY, HIGH);
    }
    const uint8_t switches[] = {config::LEFT_ENCODER_A, config::LEFT_ENCODER_B,
                                config::RIGHT_ENCODER_A, config::RIGHT_ENCODER_B};
    for (const uint8_t pin : switches) pinMode(pin, INPUT_PULLUP);
    for (const uint8_t pin : config::BUMPER_PINS) pinMode(pin, INPUT_PULLUP);
    attachInterrupt(digitalPinToInterrupt(config::LEFT_ENCODER_A), left_encoder, RISING);
    attachInterrupt(digitalPinToInterrupt(config::RIGHT_ENCODER_A), right_encoder, RISING);

    Serial.begin(config::BAUD);
    origin_ms = somewhere();
    static wax::Robot the_robot(config::SETTINGS, now_ms());
    robot = &the_robot;
}

void loop() {
    for (uint8_t count = 0; count < BYTES_A_ROUND && Serial.available() > 0; ++count) {
        robot->push(static_cast<uint8_t>(Serial.read()));
        wax::Frame frame;
        while (robot->next(now_ms(), frame) != wax::Verdict::NOTHING) {
        }
    }
    robot->tick(now_ms(), inputs());
    drive(config::LEFT_PWM, config::LEFT_A, config::LEFT_B, robot->left_mmps());
    drive(config::RIGHT_PWM, config::RIGHT_A, config::RIGHT_B, robot->right_mmps());

    uint8_t report[wax::REPORT_SIZE];
    if (Serial.availableForWrite() >= wax::REPORT_SIZE && robot->report(now_ms(), report))
        Serial.write(report, sizeof report);
#if defined(__AVR__)
    wdt_reset();
#endif
}
