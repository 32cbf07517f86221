// Shows that its user is still signed in at the proxy in front ([access.proxy]), as each request does.
// Only pages behind such a proxy load it.

const EVERY_MS = 15_000;

setInterval(() => {
  // Once they are signed out, the proxy leads to its own page, perhaps on another site.
  fetch("api/present", { redirect: "manual" }).catch(() => {});
}, EVERY_MS);
