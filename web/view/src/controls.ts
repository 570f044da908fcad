// Settings of the panel: from the session to the page and back.
import { significant } from '../../shared/src/numbers.js';
import { byId, setText } from './dom.js';
import type { Hands } from './hands.js';
import type { View } from './view.js';

export class Controls {
  private readonly map = byId('map', HTMLSelectElement);
  private readonly radius = byId('radius', HTMLInputElement);
  private readonly friction = byId('friction', HTMLInputElement);
  private readonly grasp = byId('grasp', HTMLInputElement);
  private readonly probedOnly = byId('probed-only', HTMLInputElement);

  constructor(private readonly view: View, hands: Hands) {
    const { session } = view, { sphere, runtime } = session;
    const on = (element: HTMLElement, event: 'input' | 'click', act: () => void) =>
      element.addEventListener(event, () => {
        act();
        view.changed(true);
      });
    on(this.radius, 'input', () => (sphere.radius = (Number(this.radius.value) / 100) * session.bounds.radius));
    on(this.friction, 'input', () => (sphere.friction = Number(this.friction.value)));
    on(this.grasp, 'input', () => (sphere.grasp = this.grasp.checked));
    on(this.map, 'input', () => (session.map = this.map.value));
    on(this.probedOnly, 'input', () => {
      session.probedOnly = this.probedOnly.checked;
      session.letGo();
    });
    for (const most of [1, 2] as const) on(this.button(`most-${most}`), 'click', () => session.setMost(most));
    for (const mode of ['hold', 'sphere'] as const)
      on(this.button(`mode-${mode}`), 'click', () => {
        session.setMode(mode);
        view.invite();
      });
    on(this.button('push'), 'click', () => hands.push(1));
    on(this.button('pull'), 'click', () => hands.push(-1));
    on(this.button('let-go'), 'click', () => session.letGo());
    on(this.button('whole'), 'click', () => view.wholeBody());

    this.map.replaceChildren(...[{ name: 'parts', title: 'Parts of the surface' }, ...session.maps].map(({ name, title }) =>
      Object.assign(document.createElement('option'), { value: name, textContent: title })));
    this.button('mode-sphere').disabled = !runtime.hasContact;
    this.button('most-2').disabled = runtime.mostTools < 2;
    if (runtime.mostTools < 2) setText(byId('tools-note', HTMLElement), 'A model answers one tool. A reduced body, of a scene with tools = 2, answers two.');
    setText(byId('probed-only-label', HTMLElement), session.data.rays.length > 0 ? 'Probed points and directions only' : 'Probed points only');
  }
  show(): void {
    const { mode, most, map, tools, probedOnly, sphere, bounds } = this.view.session;
    document.body.dataset['mode'] = mode;
    const pressed = (id: string, on: boolean) => this.button(id).setAttribute('aria-pressed', String(on));
    for (const n of [1, 2]) pressed(`most-${n}`, most === n);
    for (const name of ['hold', 'sphere']) pressed(`mode-${name}`, mode === name);
    for (const id of ['push', 'pull', 'let-go']) this.button(id).disabled = tools.length === 0;
    this.probedOnly.checked = probedOnly;
    this.grasp.checked = sphere.grasp;
    this.map.value = map;
    this.radius.value = String(Math.round((100 * sphere.radius) / bounds.radius));
    setText(byId('radius-value', HTMLElement), `${significant(1e3 * sphere.radius, 2)} mm`);
    this.friction.value = String(sphere.friction);
    setText(byId('friction-value', HTMLElement), String(sphere.friction));
  }
  private button(id: string): HTMLButtonElement {
    return byId(id, HTMLButtonElement);
  }
}
