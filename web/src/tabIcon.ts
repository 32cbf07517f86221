/** Changes the tab's icon while the user is wanted at this page. */
export function alertTab(document: Document, isWanted: boolean): void {
  const icon = document.querySelector<HTMLLinkElement>('link[rel="icon"]');
  const wanted = isWanted ? "icon-wanted.svg" : "icon.svg";
  if (icon && icon.getAttribute("href") !== wanted) icon.setAttribute("href", wanted);
}
