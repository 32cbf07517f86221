// What axe-core finds: each rule that is broken, and where.
async (tags) => {
  // A colour on its way to another is not one that somebody reads. Asked for, not awaited:
  // Chromium never tells of the end of one that is scrolled out of sight.
  while (document.getAnimations().some((one) => one instanceof CSSTransition))
    await new Promise((resolve) => setTimeout(resolve, 20));
  const { violations } = await axe.run(document, {
    runOnly: { type: "tag", values: tags },
    // Off unless asked for, although it is of WCAG 2.2 AA.
    rules: { "target-size": { enabled: true } },
    resultTypes: ["violations"],
  });
  return violations.map(({ id, help, nodes }) => ({
    id, help,
    nodes: nodes.map(({ target, failureSummary }) => [target.join(" "), failureSummary]),
  }));
}
