// Draws the charts and the body of a report. Its tables do not need it.
import '../../shared/src/locale.js';
import { Body } from './body.js';
import { drawCharts } from './charts.js';
import type { BodyData } from './data.js';

// Before the charts, whose listeners read the colours and the width of paper.
for (const [event, printing] of [['beforeprint', true], ['afterprint', false]] as const)
  addEventListener(event, () => {
    document.documentElement.classList.toggle('printing', printing);
    for (const details of document.querySelectorAll('details')) details.open = printing;
  });
drawCharts();
const place = document.getElementById('body'), data = document.getElementById('phynness-data');
if (place && data) {
  if (document.createElement('canvas').getContext('webgl2') === null) {
    place.textContent = 'This browser cannot draw the body, because WebGL 2 is missing or turned off.';
    place.className = 'key';
  } else {
    const body = new Body(place, JSON.parse(data.textContent ?? '') as BodyData);
    for (const span of document.querySelectorAll<HTMLElement>('[data-case]')) {
      const button = document.createElement('button');
      button.type = 'button';
      button.textContent = `${span.textContent ?? ''}, show`;
      button.addEventListener('click', () => {
        body.show(`case ${span.dataset['case']}`);
        body.scrollTo();
      });
      span.replaceChildren(button);
    }
    Object.assign(globalThis, { phynnessReport: body });
  }
}
