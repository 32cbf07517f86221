import { readFileSync } from "node:fs";
import { expect, it } from "vitest";
import type { Drive, DriveIn, DriveOut } from "../messages";
import { readRow, writeRow } from "./rows";

/** Written by hand, and read by the server's own tests too. */
const VECTORS: {
  to_server: { row: string; message: DriveIn }[];
  to_page: { row: string; message: DriveOut }[];
} = JSON.parse(readFileSync(new URL("../../../tests/vectors/drive.json", import.meta.url), "utf8"));

it.each(VECTORS.to_server)("writes $row", ({ row, message }) => {
  expect(writeRow(message)).toBe(row);
});

it.each(VECTORS.to_page)("reads $row", ({ row, message }) => {
  expect(readRow(row)).toEqual(message);
});

it("writes the server's times to 1 ms, others to 0.1 and all else to a thousandth", () => {
  const drive: Drive = {
    type: "drive",
    seq: 1,
    turn: 2,
    sent_server_ms: 1234.567,
    linear: 1 / 3,
    angular: -0.12345,
    held: true,
    speed: "slow",
    seen_server_ms: 99.96,
    axes: {},
    beat: "x7-_2A",
  };
  expect(writeRow(drive)).toBe('["drive",1,2,1235,0.333,-0.123,true,"slow",100,{},"x7-_2A"]');
});

it("has the order of the message type, whatever the message's order", () => {
  const ping = { pong_held_ms: null, id: 4, pong_id: 3, sent_page_ms: 5.06, type: "ping" } as const;
  expect(writeRow(ping)).toBe('["ping",4,5.1,3,null]');
});
