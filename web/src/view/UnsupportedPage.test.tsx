// @vitest-environment dom
import { getByRole, queryByText } from "@testing-library/dom";
import { render } from "preact";
import { afterEach, expect, it } from "vitest";
import { de } from "../words/de";
import { ENGLISH, language } from "../words/words";
import { UnsupportedPage } from "./UnsupportedPage";

afterEach(() => {
  language.value = ENGLISH;
});

const shown = (lacks: Parameters<typeof UnsupportedPage>[0]["lacks"]) => {
  const body = document.createElement("body");
  render(<UnsupportedPage lacks={lacks} />, body);
  return body;
};

it("says that WebRTC is missing, that it may be switched off, and which browsers have it", () => {
  const body = shown({ webrtc: true, channels: false, parts: [] });
  expect(getByRole(body, "alert").textContent).toContain("no WebRTC");
  expect(queryByText(body, /switch it on/)).not.toBeNull();
  expect(queryByText(body, /Firefox/)).not.toBeNull();
});

it("names the parts that an old browser lacks, without mentioning WebRTC", () => {
  const body = shown({ webrtc: false, channels: false, parts: ["a.b", "c"] });
  expect(getByRole(body, "alert").textContent).toContain("a.b, c");
  expect(queryByText(body, /WebRTC/)).toBeNull();
});

it("uses the reader's language", () => {
  language.value = { tag: "de", direction: "ltr", messages: de };
  const body = shown({ webrtc: false, channels: true, parts: [] });
  expect(getByRole(body, "alert").textContent).toContain("Datenkanäle");
});
