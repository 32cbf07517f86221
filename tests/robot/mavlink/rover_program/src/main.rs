//! A ground rover that speaks MAVLink as ArduPilot's does, for tests of the driver.
//!
//! usage: rover ADDRESS SYSTEM KEY|none [NAME=VALUE…]
//!
//! It obeys MANUAL_CONTROL in the mode MANUAL and body-frame velocities in GUIDED, while armed and only
//! from the ground station that its parameters name. It stops by itself as ArduPilot does: GUIDED after
//! GUID_TIMEOUT, every mode by the failsafe of the ground station (FS_GCS_…, FS_TIMEOUT, FS_ACTION).
//!
//! It writes each event as a line of JSON to its standard output, with the wall-clock time in seconds.
//! Commands on its standard input: mode N, arm, disarm, set NAME VALUE, mute, deaf, hear (ends both),
//! push MPS (somebody pushes it), reboot.

use std::collections::BTreeMap;
use std::io::{self, BufRead, Write};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use mavlink::dialects::common::{
    MavAutopilot, MavMessage, MavModeFlag, MavParamType, MavResult, MavState, MavType,
    ATTITUDE_DATA, BATTERY_STATUS_DATA, COMMAND_ACK_DATA, HEARTBEAT_DATA, LOCAL_POSITION_NED_DATA,
    PARAM_VALUE_DATA, SYS_STATUS_DATA, VFR_HUD_DATA,
};
use mavlink::error::MessageReadError;
use mavlink::{MavConnection, MavHeader, SigningConfig};

const MANUAL: u32 = 0;
const HOLD: u32 = 4;
const GUIDED: u32 = 15;
const TICK: Duration = Duration::from_millis(10);
const FULL_MPS: f32 = 1.0;
const FULL_RPS: f32 = 1.5;
/// Use velocity and yaw rate, ignore everything else.
const VELOCITY_AND_YAW_RATE: u16 = 0b0000_0101_1100_0111;
const BODY_FRAMES: [u32; 2] = [8, 9];

fn say(event: &str, rest: &str) {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
    let comma = if rest.is_empty() { "" } else { "," };
    let mut out = io::stdout().lock();
    let line = format!("{{\"t\":{:.6},\"event\":\"{event}\"{comma}{rest}}}\n", now.as_secs_f64());
    let _ = out.write_all(line.as_bytes()).and_then(|()| out.flush());
}

struct Rover {
    system: u8,
    boot: Instant,
    mode: u32,
    armed: bool,
    mute: bool,
    deaf: bool,
    parameters: BTreeMap<String, f32>,
    intervals: BTreeMap<u32, Duration>,
    sent: BTreeMap<u32, Instant>,
    /// Its set-point, and when that arrived.
    mps: f32,
    rps: f32,
    told: Instant,
    pushed_mps: f32,
    /// When its ground station was last heard.
    heard: Option<Instant>,
    lost: Option<Instant>,
    x_m: f32,
    y_m: f32,
    /// Clockwise from north, as in MAVLink.
    yaw: f32,
}

impl Rover {
    fn parameter(&self, name: &str) -> f32 {
        self.parameters.get(name).copied().unwrap_or(0.0)
    }

    fn is_ours(&self, from: u32) -> bool {
        let known = if self.parameters.contains_key("MAV_GCS_SYSID") { "MAV_GCS_SYSID" } else { "SYSID_MYGCS" };
        from as f32 == self.parameter(known)
    }

    fn drive(&mut self, mps: f32, rps: f32, why: &str) {
        self.told = Instant::now();
        if (mps, rps) != (self.mps, self.rps) {
            (self.mps, self.rps) = (mps, rps);
            say("moves", &format!("\"mps\":{mps},\"rps\":{rps},\"why\":\"{why}\""));
        }
    }

    fn change_mode(&mut self, mode: u32, why: &str) {
        self.mode = mode;
        say("mode", &format!("\"mode\":{mode},\"why\":\"{why}\""));
        self.drive(0.0, 0.0, why);
    }

    fn hear(&mut self, from: u32, message: &MavMessage) -> Vec<MavMessage> {
        match message {
            MavMessage::HEARTBEAT(beat) => {
                say("heartbeat", &format!("\"from\":{from},\"type\":{}", beat.mavtype as u8));
                if self.is_ours(from) {
                    self.heard = Some(Instant::now());
                }
            }
            MavMessage::MANUAL_CONTROL(told) if told.target == self.system => {
                say("manual", &format!("\"from\":{from},\"x\":{},\"y\":{},\"z\":{}", told.x, told.y, told.z));
                if self.is_ours(from) {
                    self.heard = Some(Instant::now());
                    if self.armed && self.mode == MANUAL {
                        let share = |axis: i16| f32::from(axis) / 1000.0;
                        // Right is positive on the wire, left in its reports.
                        self.drive(share(told.z) * FULL_MPS, -share(told.y) * FULL_RPS, "manual");
                    }
                }
            }
            MavMessage::SET_POSITION_TARGET_LOCAL_NED(told) if told.target_system == self.system => {
                let (frame, mask) = (told.coordinate_frame as u32, told.type_mask.bits());
                say("velocity", &format!(
                    "\"from\":{from},\"frame\":{frame},\"mask\":{mask},\"vx\":{},\"vy\":{},\"yaw_rate\":{}",
                    told.vx, told.vy, told.yaw_rate
                ));
                let understood = BODY_FRAMES.contains(&frame) && mask == VELOCITY_AND_YAW_RATE;
                if self.armed && self.mode == GUIDED && understood {
                    self.drive(told.vx, -told.yaw_rate, "velocity");
                }
            }
            MavMessage::PARAM_REQUEST_READ(asked) if asked.target_system == self.system => {
                let name = asked.param_id.to_str().unwrap_or_default().to_owned();
                say("asked", &format!("\"name\":\"{name}\""));
                if let Some(value) = self.parameters.get(&name) {
                    return vec![MavMessage::PARAM_VALUE(PARAM_VALUE_DATA {
                        param_value: *value,
                        param_count: self.parameters.len() as u16,
                        param_index: u16::MAX,
                        param_id: name.as_str().into(),
                        param_type: MavParamType::MAV_PARAM_TYPE_REAL32,
                    })];
                }
            }
            MavMessage::COMMAND_LONG(told) if told.target_system == self.system => {
                say("command", &format!("\"command\":{},\"param1\":{}", told.command as u32, told.param1));
                self.intervals.insert(told.param1 as u32, Duration::from_micros(told.param2 as u64));
                return vec![MavMessage::COMMAND_ACK(COMMAND_ACK_DATA {
                    command: told.command,
                    result: MavResult::MAV_RESULT_ACCEPTED,
                })];
            }
            _ => {}
        }
        Vec::new()
    }

    /// Let time pass: drive, check the failsafes, and return the due messages.
    fn tick(&mut self) -> Vec<MavMessage> {
        let dt = TICK.as_secs_f32();
        let mps = if self.armed { self.mps } else { 0.0 } + self.pushed_mps;
        self.yaw -= if self.armed { self.rps } else { 0.0 } * dt;
        self.x_m += mps * self.yaw.cos() * dt;
        self.y_m += mps * self.yaw.sin() * dt;
        let moves = self.mps != 0.0 || self.rps != 0.0;
        if self.mode == GUIDED && moves && self.told.elapsed().as_secs_f32() > self.parameter("GUID_TIMEOUT") {
            self.drive(0.0, 0.0, "guided timeout");
        }
        self.watch_ground_station();
        let boot_ms = self.boot.elapsed().as_millis() as u32;
        let mut due = Vec::new();
        if self.is_due(0, Some(Duration::from_secs(1))) {
            due.push(self.heartbeat());
        }
        if self.is_due(74, None) {
            due.push(MavMessage::VFR_HUD(VFR_HUD_DATA { groundspeed: mps.abs(), ..Default::default() }));
        }
        if self.is_due(32, None) {
            due.push(MavMessage::LOCAL_POSITION_NED(LOCAL_POSITION_NED_DATA {
                time_boot_ms: boot_ms,
                x: self.x_m,
                y: self.y_m,
                ..Default::default()
            }));
        }
        if self.is_due(30, None) {
            due.push(MavMessage::ATTITUDE(ATTITUDE_DATA {
                time_boot_ms: boot_ms,
                yaw: self.yaw,
                yawspeed: if self.armed { -self.rps } else { 0.0 },
                ..Default::default()
            }));
        }
        if self.is_due(147, None) {
            let mut voltages = [u16::MAX; 10];
            (voltages[0], voltages[1]) = (4100, 4000);
            due.push(MavMessage::BATTERY_STATUS(BATTERY_STATUS_DATA {
                voltages,
                battery_remaining: 62,
                ..Default::default()
            }));
        }
        if self.is_due(1, None) {
            due.push(MavMessage::SYS_STATUS(SYS_STATUS_DATA {
                voltage_battery: 8100,
                battery_remaining: 62,
                ..Default::default()
            }));
        }
        due
    }

    fn heartbeat(&self) -> MavMessage {
        let mut base_mode = MavModeFlag::MAV_MODE_FLAG_CUSTOM_MODE_ENABLED;
        if self.armed {
            base_mode |= MavModeFlag::MAV_MODE_FLAG_SAFETY_ARMED;
        }
        MavMessage::HEARTBEAT(HEARTBEAT_DATA {
            custom_mode: self.mode,
            mavtype: MavType::MAV_TYPE_GROUND_ROVER,
            autopilot: MavAutopilot::MAV_AUTOPILOT_ARDUPILOTMEGA,
            base_mode,
            system_status: MavState::MAV_STATE_ACTIVE,
            mavlink_version: 3,
        })
    }

    /// The ground station's failsafe; it never acts before the first heartbeat.
    fn watch_ground_station(&mut self) {
        let silent = self.heard.is_some_and(|at| at.elapsed().as_secs_f32() > self.parameter("FS_GCS_TIMEOUT"));
        if self.parameter("FS_GCS_ENABLE") == 0.0 || !silent {
            self.lost = None;
            return;
        }
        let since = *self.lost.get_or_insert_with(Instant::now);
        let acts = since.elapsed().as_secs_f32() > self.parameter("FS_TIMEOUT");
        if acts && self.mode != HOLD && self.parameter("FS_ACTION") == 2.0 {
            self.change_mode(HOLD, "failsafe");
        }
    }

    fn is_due(&mut self, id: u32, always: Option<Duration>) -> bool {
        let Some(interval) = always.or_else(|| self.intervals.get(&id).copied()) else { return false };
        let now = Instant::now();
        let due = self.sent.get(&id).is_none_or(|at| now - *at >= interval);
        if due {
            self.sent.insert(id, now);
        }
        due
    }

    fn obey(&mut self, words: &[&str]) {
        match words {
            ["mode", mode] => self.change_mode(mode.parse().unwrap(), "by hand"),
            ["arm"] => self.armed = true,
            ["disarm"] => {
                self.armed = false;
                self.drive(0.0, 0.0, "disarmed");
            }
            ["set", name, value] => {
                self.parameters.insert((*name).to_owned(), value.parse().unwrap());
            }
            ["mute"] => self.mute = true,
            ["deaf"] => self.deaf = true,
            ["hear"] => (self.mute, self.deaf) = (false, false),
            ["push", mps] => self.pushed_mps = mps.parse().unwrap(),
            ["reboot"] => {
                self.boot = Instant::now();
                self.intervals.clear();
                self.drive(0.0, 0.0, "reboot");
            }
            _ => panic!("what is {words:?}?"),
        }
        self.sent.remove(&0); // report a manual change at once
    }
}

fn key(hex: &str) -> [u8; 32] {
    let octet = |at: usize| u8::from_str_radix(&hex[2 * at..2 * at + 2], 16).unwrap();
    std::array::from_fn(octet)
}

fn main() -> io::Result<()> {
    let arguments: Vec<String> = std::env::args().collect();
    let [_, address, system, secret, parameters @ ..] = arguments.as_slice() else {
        panic!("usage: rover ADDRESS SYSTEM KEY|none [NAME=VALUE…]");
    };
    let mut line = mavlink::connect::<MavMessage>(address)?;
    if secret != "none" {
        line.setup_signing(Some(SigningConfig::new(key(secret), 1, true, false)));
    }
    let line = Arc::new(line);
    let system: u8 = system.parse().unwrap();
    let mut rover = Rover {
        system,
        boot: Instant::now() - Duration::from_secs(60),
        mode: HOLD,
        armed: false,
        mute: false,
        deaf: false,
        parameters: BTreeMap::new(),
        intervals: BTreeMap::new(),
        sent: BTreeMap::new(),
        mps: 0.0,
        rps: 0.0,
        told: Instant::now(),
        pushed_mps: 0.0,
        heard: None,
        lost: None,
        x_m: 0.0,
        y_m: 0.0,
        yaw: 0.0,
    };
    for parameter in parameters {
        let (name, value) = parameter.split_once('=').expect("NAME=VALUE");
        rover.parameters.insert(name.to_owned(), value.parse().unwrap());
    }
    let rover = Arc::new(Mutex::new(rover));
    let send = {
        let (line, rover) = (Arc::clone(&line), Arc::clone(&rover));
        move |messages: Vec<MavMessage>| {
            if rover.lock().unwrap().mute {
                return;
            }
            for message in messages {
                let header = MavHeader { system_id: u32::from(system), component_id: 1, sequence: 0 };
                let _ = line.send(&header, &message); // there may be no peer yet
            }
        }
    };
    {
        let (rover, send) = (Arc::clone(&rover), send.clone());
        std::thread::spawn(move || loop {
            match line.recv() {
                Ok((header, message)) => {
                    let mut rover = rover.lock().unwrap();
                    let answers = if rover.deaf { Vec::new() } else { rover.hear(header.system_id, &message) };
                    drop(rover);
                    send(answers);
                }
                Err(MessageReadError::Io(error)) if error.kind() == io::ErrorKind::UnexpectedEof => {
                    say("end", "");
                    std::process::exit(0);
                }
                Err(MessageReadError::Io(_)) => std::thread::sleep(TICK),
                Err(error) => say("refused", &format!("\"why\":\"{error:?}\"")),
            }
        });
    }
    {
        let rover = Arc::clone(&rover);
        std::thread::spawn(move || {
            for told in io::stdin().lock().lines() {
                let told = told.unwrap_or_default();
                let words: Vec<&str> = told.split_whitespace().collect();
                rover.lock().unwrap().obey(&words);
                say("told", &format!("\"words\":\"{told}\""));
            }
            std::process::exit(0); // the test has ended
        });
    }
    say("ready", "");
    loop {
        let due = rover.lock().unwrap().tick();
        send(due);
        std::thread::sleep(TICK);
    }
}
