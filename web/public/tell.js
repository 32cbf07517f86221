// Brings the page to the front when its notification is pressed. It answers no requests.

self.addEventListener("notificationclick", (event) => {
  event.notification.close();
  event.waitUntil(bringForward());
});

async function bringForward() {
  const [page] = await self.clients.matchAll({ type: "window", includeUncontrolled: true });
  await page?.focus();
}
