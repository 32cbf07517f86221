// Times the pings that WAX's page sends on the channel "drive", as the page itself sees them: from
// its call of `send` to the event that brings the answer.
const makeCommands = (clock, hooks) => {
  const table = makeTable(["at_ms", "round_trip_ms"], 6000);
  const watched = new WeakSet();
  const open = new Map(); // of each id, when it was sent

  const parse = (data, type) => {
    if (typeof data !== "string" || !data.includes(`"${type}"`)) return null;
    try {
      const message = JSON.parse(data);
      return message?.type === type ? message : null;
    } catch {
      return null;
    }
  };

  hooks.on("send", (channel, data) => {
    if (channel.label !== "drive") return;
    const ping = parse(data, "ping");
    if (ping === null) return;
    if (!watched.has(channel)) {
      watched.add(channel);
      open.clear(); // a new peer counts anew
      channel.addEventListener("message", (event) => {
        const pong = parse(event.data, "pong");
        if (pong === null || !open.has(pong.id)) return;
        const now_ms = performance.now();
        const sent_ms = open.get(pong.id);
        open.delete(pong.id);
        table.add(rounded(clock.unix(now_ms), 1), rounded(now_ms - sent_ms, 2));
      });
    }
    open.set(ping.id, performance.now());
    if (open.size > 1000) open.delete(open.keys().next().value);
  });
  return { table };
};
