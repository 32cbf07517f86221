// Publishes the parts as window[NAME], a property that no loop over the window enumerates.
if (window === window.top && !(NAME in window)) {
  const clock = makeClock();
  const hooks = makeHooks();
  const video = makeVideoProbe(clock, hooks);
  const counts = makeCounts(clock, hooks);
  const commands = makeCommands(clock, hooks);
  const states = makeTable(["at_ms", "state"], 1000);
  hooks.on("state", (state) => states.add(rounded(clock.now(), 1), state));
  const load = Math.random();

  const turn = async () => {
    try {
      clock.follow();
      hooks.look();
      video.choose();
      await counts.look();
    } catch (error) {
      console.debug(error); // a peer that was closed meanwhile
    }
    setTimeout(turn, 100);
  };
  turn();

  Object.defineProperty(window, NAME, {
    value: {
      watch: hooks.watch,
      sees: video.sees,
      look: video.look,
      handOver: video.handOver,
      take: () => ({
        load,
        opened_ms: clock.unix(0),
        first_picture_ms: video.first_ms(),
        pictures: video.table.take(),
        player_sound: commands.playerSound.take(),
        counters: counts.table.take(),
        commands: commands.table.take(),
        set_points: commands.setPoints.take(),
        connections: states.take(),
      }),
    },
  });
} else if (window.frameElement) {
  window.parent[NAME]?.watch(window);
}
