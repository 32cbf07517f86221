// Converts moments of the page's monotonic clock to Unix time. `Date.now()` is truncated to whole
// milliseconds, and `timeOrigin` keeps the wall clock's error at the page's opening. So each look
// bounds the offset between the two clocks from both sides, and moves it only if it lies outside. It
// follows a wall clock that is slewed or set. Residual error: ± 0.5 ms.
const makeClock = () => {
  let offset_ms = Date.now() + 0.5 - performance.now();
  const follow = () => {
    const before_ms = performance.now();
    const wall_ms = Date.now();
    const after_ms = performance.now();
    const low_ms = wall_ms - after_ms;
    const high_ms = wall_ms + 1 - before_ms;
    offset_ms = Math.min(Math.max(offset_ms, low_ms), high_ms);
  };
  for (let i = 0; i < 20; i++) follow();
  return {
    follow,
    unix: (page_ms) => page_ms + offset_ms,
    now: () => performance.now() + offset_ms,
  };
};

// A table whose oldest rows go first when it is full; `take` empties it into columns.
const makeTable = (columns, most_rows) => {
  let rows = [];
  return {
    add: (...row) => {
      rows.push(row);
      if (rows.length > most_rows * 1.1) rows.splice(0, rows.length - most_rows);
    },
    take: () => {
      const taken = Object.fromEntries(columns.map((name, i) => [name, rows.map((row) => row[i])]));
      rows = [];
      return taken;
    },
  };
};

const rounded = (value, digits) => (value === null ? null : Number(value.toFixed(digits)));
