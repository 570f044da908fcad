// Draws a report: its sections with tables and charts, and the body.
import '../../shared/src/locale.js';
import { drawSection, drawTitle } from './blocks.js';
import { Body } from './body.js';
import type { PageData } from './data.js';

// Before the charts, whose listeners read the colours and the width of paper.
for (const [event, printing] of [['beforeprint', true], ['afterprint', false]] as const)
  addEventListener(event, () => {
    document.documentElement.classList.toggle('printing', printing);
    for (const details of document.querySelectorAll('details')) details.open = printing;
  });
const page = JSON.parse(document.getElementById('phynness-data')!.textContent ?? '') as PageData;
drawTitle(page.title);
page.sections.forEach(drawSection);

function drawBody(): Body | null {
  const place = document.getElementById('body');
  const data = page.sections.flatMap(({ blocks }) => blocks).find(({ body }) => body)?.body;
  if (!place || !data) return null;
  if (document.createElement('canvas').getContext('webgl2') === null) {
    place.textContent = 'This browser cannot draw the body, because WebGL 2 is missing or turned off.';
    place.className = 'key';
    return null;
  }
  const body = new Body(place, data);
  for (const cell of document.querySelectorAll<HTMLElement>('[data-case]')) {
    const button = document.createElement('button');
    button.type = 'button';
    button.textContent = `${cell.textContent ?? ''}, show`;
    button.addEventListener('click', () => {
      body.show(`case ${cell.dataset['case']}`);
      body.scrollTo();
    });
    cell.replaceChildren(button);
  }
  return body;
}
// After the charts, which wait until the sections are on the page.
queueMicrotask(() => Object.assign(globalThis, { phynnessReport: drawBody() ?? {} }));
