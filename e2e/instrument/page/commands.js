// Times the pings that WAX's page sends on the channel "drive", as the page itself sees them: from
// its call of `send` to the event with the answer. Set-points, which have no answer, share the
// channel; the time of each `send` is recorded. So do reports; those of the page's built-in player
// have counts of the sound, which the browser does not have.
// A message is a list: its kind, then a ping's or pong's number, or a report's counts of the sound.
const makeCommands = (clock, hooks) => {
  const table = makeTable(["at_ms", "round_trip_ms"], 6000);
  const setPoints = makeTable(["at_ms"], 40_000);
  const playerSound = makeTable(["at_ms", "played_ms", "concealed_ms", "stretched_ms"], 6000);
  const watched = new WeakSet();
  const open = new Map(); // when each id was sent

  hooks.on("send", (channel, data) => {
    if (channel.label !== "drive") return;
    const [type, second] = JSON.parse(data);
    if (type === "drive") setPoints.add(rounded(clock.now(), 1));
    if (type === "report" && second) {
      const sound = Object.fromEntries(SOUND_REPORT.map((name, at) => [name, second[at]]));
      if (sound.player !== "browser") {
        const { played_ms, concealed_ms, stretched_ms } = sound;
        playerSound.add(rounded(clock.now(), 1), played_ms, concealed_ms, stretched_ms);
      }
    }
    if (type !== "ping") return;
    if (!watched.has(channel)) {
      watched.add(channel);
      open.clear(); // a new peer counts anew
      channel.addEventListener("message", (event) => {
        const [answer, id] = JSON.parse(event.data);
        if (answer !== "pong" || !open.has(id)) return;
        const now_ms = performance.now();
        const sent_ms = open.get(id);
        open.delete(id);
        table.add(rounded(clock.unix(now_ms), 1), rounded(now_ms - sent_ms, 2));
      });
    }
    open.set(second, performance.now());
    if (open.size > 1000) open.delete(open.keys().next().value);
  });
  return { table, setPoints, playerSound };
};
