// Elements of the page.

/** @throws Error if the page has no such element */
export function byId<T extends HTMLElement>(id: string, type: new () => T): T {
  const element = document.getElementById(id);
  if (!(element instanceof type)) throw new Error(`the page has no ${type.name} "${id}"`);
  return element;
}

/** Sets a text only when it changes, so that screen readers and layout rest otherwise. */
export function setText(element: Element, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

/** Rows of a description list. */
export function setFacts(list: HTMLElement, facts: readonly (readonly [string, string])[]): void {
  facts.forEach(([name, value], i) => {
    let dt = list.children[2 * i], dd = list.children[2 * i + 1];
    if (!dt || !dd) {
      dt = list.appendChild(document.createElement('dt'));
      dd = list.appendChild(document.createElement('dd'));
    }
    setText(dt, name);
    setText(dd, value);
  });
  while (list.children.length > 2 * facts.length) list.lastElementChild!.remove();
}
