import { beforeEach, expect, it, vi } from "vitest";
import { type Proof, Prover } from "./proof";
import { says } from "./words/said";

let told: Proof[];
let asked: string[];
let now: Proof | { error: string };
const complain = vi.fn();
let prover: Prover;

beforeEach(() => {
  vi.useFakeTimers();
  told = [];
  asked = [];
  complain.mockClear();
  vi.stubGlobal("fetch", async (path: string, { method = "GET", body }: RequestInit) => {
    asked.push([method, path, ...(body ? [body] : [])].join(" "));
    return new Response(JSON.stringify(now), { status: "error" in now ? 403 : 200 });
  });
  prover = new Prover({ tell: (proof) => told.push(proof), complain });
});

const RUNNING: Proof = {
  state: "running",
  line: says("The page is closed (3 of 40)"),
  record: null,
};
const DONE: Proof = {
  state: "done",
  line: says("Every link was cut 5 times; the robot stood within 200 ms."),
  record: "api/proof/record",
};

it("starts with the confirmation that the wheels are lifted, and polls each second until the end", async () => {
  now = RUNNING;
  await prover.start();
  expect(asked).toEqual(['POST api/proof {"lifted":true}']);
  await vi.advanceTimersByTimeAsync(2500);
  expect(asked.slice(1)).toEqual(["GET api/proof", "GET api/proof"]);
  now = DONE;
  await vi.advanceTimersByTimeAsync(5000);
  expect(asked).toHaveLength(4);
  expect(told.at(-1)).toEqual(DONE);
});

it("keeps polling if an answer is missed", async () => {
  now = RUNNING;
  await prover.start();
  now = { error: "The server does not answer." };
  await vi.advanceTimersByTimeAsync(1500);
  expect(complain).toHaveBeenCalledWith("The server does not answer.");
  now = DONE;
  await vi.advanceTimersByTimeAsync(1000);
  expect(told.at(-1)).toEqual(DONE);
});

it("polls once if none is running", async () => {
  now = DONE;
  await prover.poll();
  await vi.advanceTimersByTimeAsync(5000);
  expect(asked).toEqual(["GET api/proof"]);
});

it("says why it was refused, and stops polling", async () => {
  now = { error: "A proof is already running." };
  await prover.start();
  expect(complain).toHaveBeenCalledWith("A proof is already running.");
  await vi.advanceTimersByTimeAsync(5000);
  expect(asked).toHaveLength(1);
});
