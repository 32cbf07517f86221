/**
 * The time code that a camera films. Pure.
 *
 * Lengths are in modules: a finder in each corner, as a QR code has in three; between them, above and
 * below, the same cells twice, so that one of the two may be covered; across the middle an edge that
 * moves from left to right once a period. The cells count periods, and the edge says the rest: it is
 * read well where a long exposure blurs it, while cells that have just changed are not read at all.
 */

export const WIDTH = 36;
export const HEIGHT = 22;
/** The white margin around the code, which the finders need. */
export const MARGIN = 2;
/** From a finder's centre to the code's nearest sides. */
export const TO_CENTRE = 3.5;
/** The rows of the edge's strip. */
export const STRIP = { top: 8, height: 6 };
/** Between these columns the edge moves. */
const EDGE = { left: 2, right: 34 };
export const PERIOD_MS = 256;
/** Times repeat after this. */
export const REPEATS_MS = 256 * PERIOD_MS;

const NUMBER_BITS = 8;
const CHECK_BITS = 12;
const BITS = NUMBER_BITS + CHECK_BITS;
const COLUMNS = 10;
const CELL = { left: 8, width: 2, height: 3.5 };
const COPIES = [0, 15];
/** CRC-12 (x¹² + x¹¹ + x³ + x² + x + 1), and what keeps equal cells from being valid. */
const POLYNOMIAL = 0x80f;
const MASK = 0xa5c;

/** A rectangle: left, top, width, height; black unless it `isWhite`, and over those before it. */
export interface Patch {
  box: readonly [number, number, number, number];
  isWhite: boolean;
}

/** The code of this time, to be painted in this order on white. */
export function patches(ms: number): Patch[] {
  const inPeriods = ms / PERIOD_MS;
  const period = Math.floor(inPeriods);
  const edge = EDGE.left + (EDGE.right - EDGE.left) * (inPeriods - period);
  const drawn: Patch[] = [
    { box: [edge, STRIP.top, WIDTH - edge, STRIP.height], isWhite: false },
    ...[0, WIDTH - 7].flatMap((x) => [0, HEIGHT - 7].flatMap((y) => finder(x, y))),
  ];
  const bits = bitsOf(((period % 256) + 256) % 256);
  for (const copy of cellCentres()) {
    copy.forEach(({ x, y }, at) => {
      const { width, height } = CELL;
      if (!bits[at])
        drawn.push({ box: [x - width / 2, y - height / 2, width, height], isWhite: false });
    });
  }
  return drawn;
}

/** The centres of the cells, of each copy in the order of the bits. */
export function cellCentres(): { x: number; y: number }[][] {
  const { left, width, height } = CELL;
  return COPIES.map((top) =>
    Array.from({ length: BITS }, (_, at) => ({
      x: left + width * ((at % COLUMNS) + 0.5),
      y: top + height * (Math.floor(at / COLUMNS) + 0.5),
    })),
  );
}

/** The number that these bits stand for; null if their check fails. */
export function numberOf(bits: readonly boolean[]): number | null {
  const number = bits.slice(0, NUMBER_BITS).reduce((sum, bit) => 2 * sum + Number(bit), 0);
  return bitsOf(number).every((bit, at) => bit === bits[at]) ? number : null;
}

/**
 * The time, within `REPEATS_MS`, of this number and this column of the edge; null near a change of
 * the number, when a picture may show some of both.
 */
export function timeOf(number: number, edge: number): number | null {
  const share = (edge - EDGE.left) / (EDGE.right - EDGE.left);
  return share < 1 / 8 || share > 7 / 8 ? null : (number + share) * PERIOD_MS;
}

function finder(x: number, y: number): Patch[] {
  return [7, 5, 3].map((size, at) => ({
    box: [x + at, y + at, size, size],
    isWhite: at === 1,
  }));
}

function bitsOf(number: number): boolean[] {
  let check = 0;
  for (let bit = NUMBER_BITS - 1; bit >= 0; bit--) {
    const carries = ((check >> (CHECK_BITS - 1)) ^ (number >> bit)) & 1;
    check = ((check << 1) & 0xfff) ^ (carries ? POLYNOMIAL : 0);
  }
  const all = (number << CHECK_BITS) | (check ^ MASK);
  return Array.from({ length: BITS }, (_, at) => ((all >> (BITS - 1 - at)) & 1) === 1);
}
