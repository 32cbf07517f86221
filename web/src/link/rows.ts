/**
 * Messages of the drive channel as rows: JSON arrays of the fields in the server's order, rows
 * within rows, because a modem's uplink must carry twenty set-points a second. Absent fields at a
 * row's end are left out.
 */

import { DRIVE_COLUMNS, type DriveIn, type DriveOut } from "../messages";

interface Columns {
  readonly [name: string]: Columns | null;
}

const COLUMNS: Readonly<Record<string, Columns>> = DRIVE_COLUMNS;

/** Returns a message as a row: the server's times to 1 ms, other times to 0.1, the rest to 0.001. */
export function writeRow(message: DriveIn): string {
  return JSON.stringify(row(message, COLUMNS[message.type] ?? {}));
}

/** Parses a row from the server. */
export function readRow(text: string): DriveOut {
  const cells = JSON.parse(text);
  return named(cells, COLUMNS[cells[0]] ?? {}) as unknown as DriveOut;
}

function row(values: object, columns: Columns): unknown[] {
  const cells = Object.entries(columns).map(([name, inner]) => {
    const value = Reflect.get(values, name);
    if (inner && value !== null) return row(value, inner);
    return typeof value === "number" ? rounded(value, parts(name)) : value;
  });
  return cells.slice(0, cells.findLastIndex((cell) => cell !== undefined) + 1);
}

function parts(name: string): number {
  if (name.endsWith("_server_ms")) return 1;
  return name.endsWith("_ms") ? 10 : 1000;
}

function rounded(value: number, parts: number): number {
  return Number.isInteger(value) ? value : Math.round(value * parts) / parts;
}

function named(cells: unknown[], columns: Columns): Record<string, unknown> {
  return Object.fromEntries(
    Object.entries(columns).map(([name, inner], i) => {
      const cell = cells[i];
      return [name, inner && Array.isArray(cell) ? named(cell, inner) : cell];
    }),
  );
}
