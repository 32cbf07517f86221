// WAX on an Arduino Uno, Nano or similar: serial frames in, two to four motors and up to four servos out.
//
// This is the port for AVR boards: what src/port.h asks for, by Arduino's functions. Settings of a
// robot are in config.h; everything that decides about motion is in src/core and src/program.cpp,
// which WAX's tests also run.

#if defined(__AVR__)
#include <avr/wdt.h>
#endif

#include "config.h"
#include "src/core/crc16.h"
#include "src/port.h"
#include "src/program.h"

namespace {

struct Bridge {
    uint8_t pwm, a, b;
};

const Bridge BRIDGES[] = {{config::LEFT_PWM, config::LEFT_A, config::LEFT_B},
                          {config::RIGHT_PWM, config::RIGHT_A, config::RIGHT_B},
                          {config::BACK_PWM, config::BACK_A, config::BACK_B},
                          {config::BACK_RIGHT_PWM, config::BACK_RIGHT_A, config::BACK_RIGHT_B}};
static_assert(config::BASE == wax::Kind::SIDES || config::BACK_PWM != config::NONE,
              "a base that moves sideways needs the pins of its back wheel");
static_assert(config::BASE != wax::Kind::MECANUM || config::BACK_RIGHT_PWM != config::NONE,
              "four mecanum wheels need the pins of the fourth: BACK_RIGHT");

constexpr bool is_encoders(uint8_t pin) {
    return pin != config::NONE &&
           (pin == config::LEFT_ENCODER_A || pin == config::LEFT_ENCODER_B ||
            pin == config::RIGHT_ENCODER_A || pin == config::RIGHT_ENCODER_B);
}
constexpr bool is_apart(uint8_t pwm, uint8_t a, uint8_t b) {
    return pwm == config::NONE || !(is_encoders(pwm) || is_encoders(a) || is_encoders(b));
}
static_assert(is_apart(config::LEFT_PWM, config::LEFT_A, config::LEFT_B) &&
                  is_apart(config::RIGHT_PWM, config::RIGHT_A, config::RIGHT_B) &&
                  is_apart(config::BACK_PWM, config::BACK_A, config::BACK_B) &&
                  is_apart(config::BACK_RIGHT_PWM, config::BACK_RIGHT_A, config::BACK_RIGHT_B),
              "a motor's pin is an encoder's too; set that encoder to NONE");

volatile int32_t counts[2];

void left_encoder() { counts[0] += digitalRead(config::LEFT_ENCODER_B) ? 1 : -1; }
void right_encoder() { counts[1] += digitalRead(config::RIGHT_ENCODER_B) ? 1 : -1; }

constexpr bool has_servos(uint8_t from = 0) {
    return from < wax::AXES &&
           (config::SERVO_PINS[from] != config::NONE || has_servos(static_cast<uint8_t>(from + 1)));
}

}  // namespace

#if defined(__AVR__) && defined(TCCR1A)

// Timer 1 gives the servos their pulses, one after the other.
namespace {

constexpr bool is_timers(uint8_t pin) { return pin == 9 || pin == 10; }
static_assert(!has_servos() || !(is_timers(config::LEFT_PWM) || is_timers(config::RIGHT_PWM) ||
                                 is_timers(config::BACK_PWM) || is_timers(config::BACK_RIGHT_PWM)),
              "pins 9 and 10 have no PWM where servos are; wire the motors' PWM to 3, 5, 6 or 11");

const uint8_t STEPS_A_US = F_CPU / 8000000;
const uint16_t ROUND_STEPS = 1000 * port::SERVO_EVERY_MS * STEPS_A_US;
const uint16_t SOON_STEPS = 20 * STEPS_A_US;  // longer than the interrupt takes

volatile uint16_t pulses_us[wax::AXES];
volatile uint8_t *outputs[wax::AXES];  // as digitalWrite finds them, which takes too long for a pulse
uint8_t bits[wax::AXES];

void begin_servos() {
    if (!has_servos()) return;  // whose timer gives pins 9 and 10 their PWM
    for (uint8_t axis = 0; axis < wax::AXES; ++axis) {
        const uint8_t pin = config::SERVO_PINS[axis];
        if (pin == config::NONE) continue;
        pinMode(pin, OUTPUT);
        outputs[axis] = portOutputRegister(digitalPinToPort(pin));
        bits[axis] = digitalPinToBitMask(pin);
    }
    TCCR1A = 0;
    TCCR1B = _BV(CS11);
    OCR1A = TCNT1 + ROUND_STEPS;
    TIMSK1 = _BV(OCIE1A);
}

void set_pulse(uint8_t axis, uint16_t pulse_us) {
    noInterrupts();
    pulses_us[axis] = pulse_us;
    interrupts();
}

}  // namespace

// End one servo's pulse and begin the next one's, or wait for the round to end.
ISR(TIMER1_COMPA_vect) {
    static uint8_t at = wax::AXES;
    static uint16_t began;
    if (at < wax::AXES && bits[at] != 0) *outputs[at] &= static_cast<uint8_t>(~bits[at]);
    at = at < wax::AXES ? static_cast<uint8_t>(at + 1) : 0;
    if (at == 0) began = TCNT1;
    if (at == wax::AXES) {
        OCR1A = static_cast<uint16_t>(began + ROUND_STEPS);
        return;
    }
    const uint16_t pulse_us = pulses_us[at];
    const bool has_one = pulse_us != 0 && bits[at] != 0;
    if (has_one) *outputs[at] |= bits[at];
    OCR1A = static_cast<uint16_t>(TCNT1 + (has_one ? pulse_us * STEPS_A_US : SOON_STEPS));
}

#else

namespace {

static_assert(!has_servos(), "servos on this board need a port of their own: see PORTING.md");

void begin_servos() {}
void set_pulse(uint8_t, uint16_t) {}

}  // namespace

#endif

namespace port {

void begin() {
#if defined(__AVR__)
    // A program that hangs restarts, with the motors off. The bootloader of Nanos from before 2018
    // then restarts for ever: install Optiboot on such a board.
    wdt_enable(WDTO_60MS);
#endif
    for (const Bridge &bridge : BRIDGES) {
        if (bridge.pwm == config::NONE) continue;
        pinMode(bridge.pwm, OUTPUT);
        pinMode(bridge.a, OUTPUT);
        pinMode(bridge.b, OUTPUT);
    }
    if (config::STANDBY != config::NONE) {
        pinMode(config::STANDBY, OUTPUT);
        digitalWrite(config::STANDBY, HIGH);
    }
    const uint8_t switches[] = {config::LEFT_ENCODER_A, config::LEFT_ENCODER_B,
                                config::RIGHT_ENCODER_A, config::RIGHT_ENCODER_B};
    for (const uint8_t pin : switches)
        if (pin != config::NONE) pinMode(pin, INPUT_PULLUP);
    for (const uint8_t pin : config::BUMPER_PINS) pinMode(pin, INPUT_PULLUP);
    if (config::LEFT_ENCODER_A != config::NONE)
        attachInterrupt(digitalPinToInterrupt(config::LEFT_ENCODER_A), left_encoder, RISING);
    if (config::RIGHT_ENCODER_A != config::NONE)
        attachInterrupt(digitalPinToInterrupt(config::RIGHT_ENCODER_A), right_encoder, RISING);
    begin_servos();
    Serial.begin(config::BAUD);
}

uint32_t now_ms() { return millis(); }

uint32_t noise() {
    uint8_t octets[32];
    for (uint8_t &octet : octets)
        octet = static_cast<uint8_t>(analogRead(A0) + (analogRead(A5) << 4) + micros());
    return static_cast<uint32_t>(wax::crc16(octets, sizeof octets, 0)) << 16 |
           wax::crc16(octets, sizeof octets / 2, 0);
}

bool read(uint8_t &byte) {
    const int found = Serial.read();
    byte = static_cast<uint8_t>(found);
    return found >= 0;
}

uint16_t room() { return static_cast<uint16_t>(Serial.availableForWrite()); }

void write(const uint8_t *bytes, uint8_t size) { Serial.write(bytes, size); }

// At 0 both outputs of the bridge are equal, which brakes.
void motor(Wheel wheel, int16_t power) {
    const Bridge &bridge = BRIDGES[wheel];
    if (bridge.pwm == config::NONE) return;
    digitalWrite(bridge.a, power >= 0);
    digitalWrite(bridge.b, power <= 0);
    analogWrite(bridge.pwm, power == 0 ? wax::FULL_POWER : power < 0 ? -power : power);
}

void servo(uint8_t axis, uint16_t pulse_us) { set_pulse(axis, pulse_us); }

uint16_t battery() {
    if (config::BATTERY_PIN == config::NONE) return 0;
    return static_cast<uint16_t>(analogRead(config::BATTERY_PIN));
}

uint16_t battery_full_scale() { return 1023; }

uint8_t bumpers() {
    uint8_t pressed = 0;
    for (uint8_t at = 0; at < config::BUMPERS; ++at)
        if (!digitalRead(config::BUMPER_PINS[at])) pressed = static_cast<uint8_t>(pressed | 1 << at);
    return pressed;
}

int32_t ticks(Wheel wheel) {
    noInterrupts();
    const int32_t now = counts[wheel];
    interrupts();
    return now;
}

void feed_watchdog() {
#if defined(__AVR__)
    wdt_reset();
#endif
}

}  // namespace port

wax::Program *program;

void setup() {
    port::begin();
    static wax::Program the_program(config::SETTINGS, config::BODY);
    program = &the_program;
}

void loop() { program->loop(); }
