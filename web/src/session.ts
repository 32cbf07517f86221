/** The composition root: builds every part and wires it. Views get `state` and `actions`. */

import { type Asked, newRequest } from "./aboard";
import type { Actions, Session } from "./actions";
import { listenFirstDrive } from "./branding/welcome";
import { missedCall } from "./call";
import { Cameras } from "./cameras";
import { Chime } from "./chime";
import { DriveController } from "./drive/driveController";
import type { PadNews } from "./drive/gamepads";
import { readKeyCaps } from "./drive/keyCaps";
import { actionOf, type KeyAction } from "./drive/keyMap";
import { FLOOR_HZ } from "./drive/sendRate";
import { StopControl } from "./drive/stopControl";
import { type Entry, showEntry, takeEntry } from "./entry";
import { keepFocus, returnFocusAfterPointer } from "./focus";
import { isFramed } from "./framed";
import { freePicture } from "./freePicture";
import { applyPlayout } from "./jitterBufferTargets";
import { clickDespiteShift } from "./layoutShift";
import { Identity, openIdentityChannel } from "./link/identity";
import { Link } from "./link/link";
import { watchNetwork } from "./link/network";
import type { Peer } from "./link/peer";
import type { Sent } from "./link/signalling";
import { cameOverThin, isThin } from "./link/thin";
import { listenKey } from "./listenKey";
import { tellsFrames, watchFrames } from "./measure/picture";
import { measureRefresh } from "./measure/refresh";
import { Reporter } from "./measure/report";
import {
  type Ended,
  MAX_NAME_CHARS,
  MAX_TASK_CHARS,
  type RoomChange,
  type RoomState,
  type StateOut,
} from "./messages";
import { Playback } from "./playback";
import { loadPreferences, openStore, type Preferences, savePreferences } from "./preferences";
import { Prover } from "./proof";
import { Acknowledger } from "./receipt/acknowledge";
import { changed } from "./roomChange";
import type { RoomViewer } from "./rooms/roomViewer";
import { ShownPicture } from "./shownPicture";
import { loadAhead } from "./sound/builtInPlayer";
import { createHearing } from "./sound/hearing";
import { SoundPlayback } from "./sound/soundPlayback";
import { createState } from "./state";
import { recordHistory } from "./stats/record";
import { askToNotify, listenNotifications } from "./turnNotification";
import { listenTurnOver } from "./turnOver";
import { listenTalk } from "./voice/listenTalk";
import { Talk } from "./voice/talk";
import { keepAwake, needsScreen } from "./wakeLock";
import { WantedSize } from "./wantedSize";
import { type Unsettled, within } from "./within";
import {
  followLanguageChoice,
  languageWishes,
  pickLanguage,
  switchLanguage,
} from "./words/language";
import { LateWords } from "./words/lateWords";
import { pageSentence, type Saying, said, says } from "./words/said";
import { t } from "./words/words";

const CLOCKS_EVERY_MS = 200;
/** Pages that wait for the opening reconnect spread over this time. */
const OPENING_MS = 20_000;
/** The pause before a failed load is retried. */
const LOAD_AGAIN_MS = 5000;
/** The page connects without words and player after this: 34 kB take 10 s on the slowest modem. */
const LOADED_WITHIN_MS = 12_000;
/** Without a first picture and sound after this long, there may be none. */
const MEDIA_WITHIN_MS = 4000;
/** How long a request by the person aboard is shown. */
const REQUEST_MS = 15_000;
const PAD_NEWS = {
  found: "ways.pad_found",
  found_by_menu: "ways.pad_found_by_menu",
  lost: "ways.pad_lost",
  frozen: "ways.pad_frozen",
  not_loaded: "late.failed",
} as const;

/** Connects at once, before anything is drawn. */
export function startSession(): Session {
  // In a frame on another site nobody drives, presses Stop or opens a link, and nothing is stored.
  const isEmbed = isFramed();
  // Before anything else, so that nothing can send or keep the secret.
  const entry = isEmbed ? null : takeEntry(window);
  const store = isEmbed ? null : openStore(() => window.localStorage);
  const state = createState(loadPreferences(store));
  const history = recordHistory(state);
  const picture = new Playback({ silenced: offerStart });
  const sound = new SoundPlayback({
    changed(player) {
      state.player.value = player;
    },
    reconnect: () => link.connect(),
    silenced() {
      state.isSoundOn.value = false;
      offerStart();
      sendWant();
    },
    resumed: () => actions.setSound(true),
  });
  const wantedSize = new WantedSize({ ...state, changed: sendWant });
  const identity = new Identity(isEmbed ? null : openStore(() => window.sessionStorage));

  const words = new LateWords();
  const chime = new Chime();
  const acknowledger = new Acknowledger((received) => link.sendState(received));

  let tellOffered = () => {};
  const offered = new Promise<void>((resolve) => {
    tellOffered = resolve;
  });
  const link = new Link(() => identity.client, {
    offered: () => tellOffered(),
    changed: (now) => {
      if (roomViewer) roomViewer.linkChanged(now);
      else state.link.value = now;
    },
    fresh,
    sent: (where) => void goToRoom(where),
    received,
    operated: (answer) => controller.operating.answered(answer),
    receivers(ofSound, ofPicture) {
      if (acknowledger.isReady) acknowledger.watch(ofSound, ofPicture);
      else sound.watch(ofSound);
    },
  });

  /** Watches LiveKit rooms once the server is full; loaded only then. */
  let roomViewer: RoomViewer | null = null;

  const wants = () => ({
    sound: state.isSoundOn.peek(),
    picture: state.preferences.peek().picture,
  });
  const reporter = new Reporter({
    link,
    wants,
    heard: (nowMs) => sound.heard(nowMs),
    onFacts: (facts) => {
      if (!roomViewer?.isOnScreen) state.facts.value = facts;
    },
  });

  const seenServerMs = () => (wants().picture ? reporter.picture.newestServerMs : null);
  const controller = new DriveController({
    state,
    serverMs: () => link.clock.toServerMs(performance.now()),
    beat: () => link.beat,
    seenServerMs,
    uplink: () => ({
      linkBps: state.served.peek()?.link_bps ?? null,
      waitingBytes: link.peer?.waitingBytes ?? 0,
      queuedMs: link.clock.queuedMs,
    }),
    send: (drive, urgent) => link.sendDrive(drive, urgent),
    operate: (operate, urgent) => link.sendDrive(operate, urgent),
    refused: (why) => say(why ?? t("controls.lost")),
  });
  const letGo = () => controller.letGo();
  const stopControl = new StopControl({ state, link, client: () => identity.client, letGo, say });

  const talk = new Talk({
    link: () => link.peer,
    uplink: () => ({
      ...controller.uplink(),
      roundTripMs: state.facts.peek().roundTripMs,
      commandHz: state.drivingTurn.peek() === null ? 0 : FLOOR_HZ,
    }),
    changed: (voice) => {
      state.voice.value = voice;
    },
    soundMs: () => state.facts.peek().soundMs ?? 0,
    duck: (isDucked) => {
      sound.isDucked = isDucked;
    },
  });

  /** Shows the Start button: the system has paused the sound, or demands a touch. */
  function offerStart(): void {
    state.isStartOffered.value = true;
  }

  function say(what: string | Saying): void {
    state.notice.value = { text: typeof what === "string" ? says(what) : what };
  }

  const cameras = new Cameras({
    state,
    send: (message) => void link.sendState(message),
    say,
    tellsFrames: tellsFrames(),
  });

  const prover = new Prover({
    tell: (proof) => {
      state.proof.value = proof;
    },
    complain: say,
  });

  function fresh(peer: Peer): void {
    const show = () => {
      picture.setTrack(peer.picture.track);
      cameras.setTracks(peer.cameras.map((one) => one.track));
      sound.setReceiver(peer.sound);
      choosePlayer();
    };
    if (roomViewer?.isOnScreen) roomViewer.arrives(peer.picture, show);
    else show();
    reporter.reset();
    talk.reconnected();
    state.driveReason.value = null;
    state.driveShare.value = 1;
    state.playout.value = null;
    state.served.value = null;
  }

  function received(message: StateOut): void {
    switch (message.type) {
      case "hello":
        // The previous connection's room may name another operator.
        state.room.value = null;
        state.request.value = null;
        state.hello.value = message;
        if (message.acknowledge && !acknowledger.isReady) void acknowledge();
        if (!hasRoomFor(message.cameras.length)) break;
        greet();
        break;
      case "room":
        enterRoom(message);
        break;
      case "room_change":
        changeRoom(message);
        break;
      case "playout":
        state.playout.value = message;
        if (link.peer) {
          applyPlayout(message, link.peer.sound, link.peer.picture);
          choosePlayer();
        }
        break;
      case "served":
        state.served.value = message;
        link.isThin = isThin(message);
        break;
      case "rtp_clock":
        reporter.mapped(message);
        break;
      case "units":
        acknowledger.units(message);
        break;
      case "drive_status":
        state.driveReason.value = message.reason;
        state.driveShare.value = message.share;
        break;
      case "heard":
        talk.reported(message.heard, message.reason ?? null);
        break;
      case "notice":
        say(message.text);
        break;
      case "ended":
        end(message);
        break;
      case "console":
        state.console.value = message;
        break;
      case "invitation":
        state.invitation.value = message;
        break;
      case "goodbye":
        break; // the link shows its text while it waits to reconnect
    }
  }

  /** Whether the peer has `count` cameras; reconnects if the server's number has changed. */
  function hasRoomFor(count: number): boolean {
    if (count === link.cameras) return true;
    link.cameras = count;
    state.large.value = null;
    queueMicrotask(() => link.connect()); // the link is still busy with this greeting
    return false;
  }

  /** Watches a LiveKit room, since the server is full. */
  async function goToRoom(where: Sent): Promise<void> {
    try {
      const loaded = await import("./rooms/roomViewer");
      roomViewer ??= new loaded.RoomViewer({
        state,
        link,
        client: () => identity.client,
        wants,
        size: () => state.size.peek() ?? wantedSize.choose() ?? "",
        show(receivers) {
          picture.setTrack(receivers.picture?.track ?? null);
          cameras.setTracks([]);
          sound.setReceiver(receivers.sound);
          sound.choose("browser", null);
          reporter.reset();
        },
        enterRoom,
        say,
      });
    } catch {
      const retryAtMs = performance.now() + LOAD_AGAIN_MS;
      state.link.value = { is: "waiting", retryAtMs, reason: pageSentence("link.not_loaded") };
      setTimeout(() => link.connect(), LOAD_AGAIN_MS);
      return;
    }
    roomViewer.sent(where);
  }

  function choosePlayer(): void {
    const playout = state.playout.peek();
    if (!playout || roomViewer?.isOnScreen) return;
    sound.leastDelayMs = playout.sound_target_ms;
    const choice = state.preferences.peek().player ?? playout.player;
    sound.choose(choice, link.peer?.redundancy ?? null);
  }

  function enterRoom(room: RoomState): void {
    const me = state.hello.peek()?.viewer;
    const before = state.room.peek();
    if (me !== undefined) {
      const told = state.missedCall.peek();
      state.missedCall.value = missedCall(before, room, me, state.serverMs.peek(), told);
      if (room.call?.viewer === me && before?.call?.viewer !== me) chime.ring();
    }
    state.room.value = room;
    cameras.roomChanged(room);
    // A person aboard who takes over needs no request any more.
    if (room.aboard?.mode === "hand" && before?.aboard?.mode !== "hand") state.request.value = null;
    const asked = newRequest(before, room);
    if (asked) tellRequest(asked);
  }

  /** Shows the request of the person aboard for a while; the operator also hears a chime. */
  function tellRequest(asked: Asked): void {
    const request = { asked };
    state.request.value = request;
    if (state.drivingTurn.peek() !== null) chime.ring();
    setTimeout(() => {
      if (state.request.peek() === request) state.request.value = null;
    }, REQUEST_MS);
  }

  function changeRoom(change: RoomChange): void {
    const room = state.room.peek();
    if (room) enterRoom(changed(room, change));
  }

  /** Shows why this page may not stay; it reconnects when the robot opens, if that is known. */
  function end(ended: Ended): void {
    roomViewer?.leave();
    state.ended.value = ended;
    state.room.value = null;
    state.console.value = null;
    state.invitation.value = null;
    const [next] = ended.openings;
    if (!next) return;
    const pauseMs = Math.max(0, next.opens_wall_ms - Date.now()) + Math.random() * OPENING_MS;
    // `setTimeout` takes at most 24 days; nobody leaves the page open for longer.
    setTimeout(
      () => {
        if (state.ended.peek() === ended) actions.comeBack();
      },
      Math.min(pauseMs, 2 ** 31 - 1),
    );
  }

  /** Redeems the secret of the opened link, if there is one, and connects. */
  async function enter(entry: Entry | null): Promise<void> {
    if (entry) {
      const { isGood, text } = await showEntry(entry);
      if (isGood) say(text);
      state.entryProblem.value = isGood ? null : text;
    }
    state.ended.value = null;
    link.connect();
  }

  /**
   * Prepares what watches packets, which the HTML names to save a reconnection. On a thin link,
   * words and player load before the media, within `LOADED_WITHIN_MS`.
   */
  async function prepare(): Promise<void> {
    const loaded = performance.getEntriesByType("resource") as PerformanceResourceTiming[];
    if (cameOverThin(loaded)) {
      // Loading them beside sound and picture would take several times as long.
      const tag = pickLanguage(languageWishes(state.preferences.peek().language));
      const late = new Promise((resolve) => setTimeout(resolve, LOADED_WITHIN_MS));
      await Promise.race([Promise.all([words.loadOnce(), switchLanguage(tag), loadAhead()]), late]);
    }
    const { acknowledge: acknowledges, player } = document.documentElement.dataset;
    const starting =
      acknowledges !== undefined
        ? acknowledger.start()
        : sound.start(state.preferences.peek().player ?? (player ? "browser" : "auto"));
    await within<unknown>("Worker", starting).catch(() => {}); // connects without it
  }

  /** Connects again, so that this page can acknowledge what it receives. */
  async function acknowledge(): Promise<void> {
    if (await acknowledger.start()) {
      link.connect();
    } else {
      say(t("link.cannot_acknowledge"));
    }
  }

  /** Sends the page's name and wishes over a new connection. */
  function greet(): void {
    const { name } = state.preferences.peek();
    stopControl.connected();
    if (name) link.sendState({ type: "name", name });
    sendWant();
    cameras.sendLook();
  }

  function sendWant(): void {
    const { policy } = state.preferences.peek();
    const size = wantedSize.choose();
    if (size) link.sendState({ type: "want", ...wants(), size, policy });
  }

  /** Sends a queue request through the LiveKit viewer if it takes it, otherwise over the link. */
  function ask(type: "join" | "leave" | "here"): void {
    if (!roomViewer?.ask(type)) link.sendState({ type });
  }

  function sendTask(): void {
    const turn = state.drivingTurn.peek();
    if (turn === null || !state.room.peek()?.tape?.asks_task) return;
    link.sendState({ type: "task", turn, text: state.task.peek() });
  }

  function prefer(change: Partial<Preferences>): void {
    state.preferences.value = { ...state.preferences.peek(), ...change };
    savePreferences(store, state.preferences.peek());
  }

  const actions: Actions = {
    ...createHearing({ state, sound, prefer, say, start: () => actions.start() }),
    start() {
      picture.play();
      actions.setSound(true);
    },
    setSound(on) {
      state.isSoundOn.value = on;
      state.isStartOffered.value = false;
      if (on) sound.play();
      else sound.pause();
      prefer({ sound: on });
      sendWant();
    },
    setPicture(on) {
      reporter.picture.unsee();
      prefer({ picture: on });
      sendWant();
    },
    setSize(size) {
      prefer({ size });
      sendWant();
    },
    setCameras(on) {
      prefer({ cameras: on });
      cameras.sendLook();
    },
    enlarge: (camera) => cameras.choose(camera),
    setPolicy(policy) {
      prefer({ policy });
      sendWant();
    },
    setPlayer(player) {
      prefer({ player });
      choosePlayer();
    },
    setName(text) {
      const name = text.trim().slice(0, MAX_NAME_CHARS);
      if (name === state.preferences.peek().name) return;
      prefer({ name });
      link.sendState({ type: "name", name });
    },
    setSpeed(speed) {
      prefer({ speed });
      controller.speedChanged();
    },
    setLanguage: (language) => prefer({ language }),
    keep: prefer,
    async tellMe(on) {
      const asking = on ? askToNotify() : Promise.resolve(null);
      within("Notification", asking).catch((hang: Unsettled) => say(said(hang.saying)));
      const why = await asking;
      prefer({ tells: on && why === null });
      if (why) say(t(why));
    },
    setAxis: (name, position) => controller.setAxis(name, position),
    recentre: () => controller.recentre(),
    holdControl: (holder, name) => controller.operating.press(holder, name),
    releaseControl: (holder) => controller.operating.release(holder),
    slideControl: (name, value) => controller.operating.slide(name, value),
    setControl: (name, value) => controller.operating.set(name, value),
    toggleControl: (name) => controller.operating.toggle(name),
    setDriving(change) {
      letGo();
      prefer(change);
    },
    useGamepad: (index) => controller.useGamepad(index),
    padRestNow: () => controller.padRestNow(),
    learnPad: (wish) => controller.learnPad(wish),
    scan: (what) => controller.scan(what),
    join: () => ask("join"),
    leave: () => ask("leave"),
    stop: () => stopControl.stop(),
    releaseStop: () => stopControl.release(),
    press: (holder, held) => controller.ways.press(holder, held),
    deflect: (holder, motion) => controller.deflect(holder, motion),
    release: (holder) => controller.ways.release(holder),
    letGo,
    answerCall: () => ask("here"),
    actAsHost: (act) => {
      if (!link.sendState(act)) say(t("link.try_in_a_moment"));
    },
    disown() {
      const turn = state.drivenTurn.peek();
      if (turn === null) return;
      if (link.sendState({ type: "disown", turn })) state.drivenTurn.value = null;
      else say(t("link.try_again"));
    },
    setTask(text) {
      state.task.value = text.trim().slice(0, MAX_TASK_CHARS);
      sendTask();
    },
    keepTape: () => {
      if (!link.sendState({ type: "keep_tape" })) say(t("link.try_again"));
    },
    comeBack() {
      state.ended.value = null;
      link.connect();
    },
    speak: (holder) => talk.press(holder),
    hush: (holder) => void talk.release(holder),
    keepSpeaking: (on) => talk.keepOpen(on),
    open(panel) {
      state.panel.value = panel;
    },
    pollProof: () => void prover.poll(),
    prove: () => void prover.start(),
  };

  link.mayHaveVoice = document.documentElement.dataset.voice !== undefined;
  link.cameras = Number(document.documentElement.dataset.cameras ?? 0);
  state.maySpeak.subscribe((may) => talk.allow(may));
  state.drivingTurn.subscribe(sendTask);
  state.me.subscribe((me) => {
    link.mayDrive = me !== null && me.role !== "observer";
  });

  const { signal } = new AbortController();
  const isKeyFor = (action: KeyAction) => (key: string, isShifted: boolean) =>
    actionOf(state.keys.peek(), key, isShifted) === action;
  const toggleSpeed = () =>
    actions.setSpeed(state.preferences.peek().speed === "slow" ? "fast" : "slow");
  const tellOfPad = (what: PadNews) => say(t(PAD_NEWS[what]));
  if (!isEmbed) {
    controller.listen(window, { ...actions, toggleSpeed, tellOfPad }, signal);
    void readKeyCaps(navigator as object);
    listenTalk(window, talk, isKeyFor("talk"), signal);
    listenKey(window, () => cameras.next(), isKeyFor("cameras"), signal);
    listenKey(window, actions.toggleMute, isKeyFor("mute"), signal);
    listenFirstDrive(state, prefer);
    returnFocusAfterPointer(document, signal);
    keepFocus(document, signal);
    clickDespiteShift(document, signal);
    listenTurnOver(state);
    listenNotifications(state);
    freePicture(window, state, signal);
    keepAwake(needsScreen(state));
    // Opening a link to a page that is already open changes only its hash.
    window.addEventListener("hashchange", () => {
      const another = takeEntry(window);
      if (another) void enter(another);
    });
    // Where there is no channel there is no storage for a duplicated tab to copy either.
    const channel = openStore(openIdentityChannel);
    if (channel) identity.share(channel, () => link.connect());
  }
  window.addEventListener("pagehide", () => {
    link.close();
    roomViewer?.giveUp();
  });
  window.addEventListener("pageshow", (event) => {
    if (event.persisted && !state.ended.peek()) link.connect();
  });
  watchNetwork(() => link.networkChanged(), signal);
  document.addEventListener("visibilitychange", () => {
    if (!document.hidden) link.hurry();
  });

  void measureRefresh().then((refreshMs) => {
    reporter.refreshMs = refreshMs;
  });
  setInterval(() => {
    state.pageMs.value = performance.now();
    const clock = state.isInRoom.peek() && roomViewer ? roomViewer : link.clock;
    state.serverMs.value = clock.toServerMs(performance.now());
    stopControl.check(performance.now());
    talk.adapt(performance.now());
    cameras.checkLive(performance.now(), document.hidden);
  }, CLOCKS_EVERY_MS);

  // After the first picture and sound, before the server is likely to have something to say.
  state.link.subscribe(({ is }) => {
    if (is === "connected") setTimeout(() => void words.loadOnce(), MEDIA_WITHIN_MS);
    else if (is === "waiting" || is === "closed") void words.loadOnce();
  });
  state.facts.subscribe(({ pictureMs, soundMs }) => {
    const wanted = wants();
    const isShown = pictureMs !== null || !wanted.picture;
    const isHeard = soundMs !== null || !wanted.sound;
    if (isShown && isHeard && state.isConnected.peek()) void words.loadOnce();
  });

  picture.play();
  void prepare().then(() => {
    void enter(entry);
    // In parallel with connecting, unless `prepare` has loaded them.
    followLanguageChoice(state.preferences, state.isLinkForDriving, say);
  });

  function presented(rtp: number | undefined, atMs: number): void {
    if (roomViewer?.isOnScreen) {
      roomViewer.presented(rtp, atMs);
      return;
    }
    link.heard();
    reporter.picture.presented(rtp, atMs);
  }

  const shown = () => roomViewer?.picture ?? link.peer?.picture;

  const elements = new ShownPicture();
  let unwatch = () => {};
  const unwatchCamera: (() => void)[] = [];
  return {
    state,
    actions,
    history,
    offered,
    seenServerMs,
    shownPicture: (camera = state.large.peek()) => elements.get(camera),
    forPhoto: (take) => (state.large.peek() === null ? wantedSize.forPhoto(take) : take()),
    attachPicture(element) {
      elements.attach(null, element);
      wantedSize.attach(element);
      unwatch();
      unwatch = element ? watchFrames(element, { presented }, shown) : () => {};
      picture.attach(element);
    },
    attachSound: (element) => sound.attach(element),
    pictureStream: () => picture.stream,
    soundLevels: () => sound.levels(),
    attachCamera(camera, element) {
      elements.attach(camera, element);
      unwatchCamera[camera]?.();
      const meter = { presented: () => cameras.presented(camera) };
      unwatchCamera[camera] = element
        ? watchFrames(element, meter, () => link.peer?.cameras[camera])
        : () => {};
      cameras.attach(camera, element);
    },
  };
}
