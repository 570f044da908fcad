// Settings of the panel: from the state to the page and back.
import { significant } from '../../shared/src/numbers.js';
import { byId, setFacts, setText } from './dom.js';
import type { Hands } from './hands.js';
import type { View } from './view.js';

type Flag = 'keep' | 'atNodes' | 'components' | 'edges' | 'nodes';
const flags: Readonly<Record<Flag, string>> = {
  keep: 'keep', atNodes: 'at-nodes', components: 'components', edges: 'edges', nodes: 'nodes',
};

export class Controls {
  private readonly map = byId('map', HTMLSelectElement);
  private readonly level = byId('level', HTMLSelectElement);
  private readonly step = byId('step', HTMLInputElement);
  private readonly ranges = {
    palpation: byId('palpation', HTMLInputElement), subdivision: byId('subdivision', HTMLInputElement),
    radius: byId('radius', HTMLInputElement), friction: byId('friction', HTMLInputElement),
  };

  constructor(private readonly actions: View, private readonly hands: Hands) {
    const state = () => actions.session.state;
    for (const [key, id] of Object.entries(flags) as [Flag, string][]) {
      const box = byId(id, HTMLInputElement);
      box.addEventListener('change', () => {
        state()[key] = box.checked;
        actions.changed(false);
      });
    }
    const range = (input: HTMLInputElement, set: (value: number) => void, physics: boolean) =>
      input.addEventListener('input', () => {
        set(Number(input.value));
        actions.changed(physics);
      });
    range(this.ranges.palpation, (v) => (state().palpationDepth = (v / 100) * actions.session.runtime.model.info.maxDisplacement), false);
    range(this.ranges.subdivision, (v) => (state().subdivision = v), false);
    range(this.ranges.radius, (v) => (state().sphere.radius = this.radiusOf(v)), true);
    range(this.ranges.friction, (v) => (state().sphere.friction = v), true);
    byId('grasp', HTMLInputElement).addEventListener('change', (event) => {
      state().sphere.grasp = (event.target as HTMLInputElement).checked;
      actions.changed(true);
    });
    this.map.addEventListener('change', () => {
      state().map = this.map.value;
      actions.changed(false);
    });
    this.level.addEventListener('change', () => {
      const index = Number(this.level.value);
      actions.session.setLevel(index === actions.session.runtime.levels.length - 1 ? null : index);
      actions.changed(true);
    });
    for (const most of [1, 2])
      byId(`most-${most}`, HTMLButtonElement).addEventListener('click', () => {
        const { session } = actions;
        while (session.state.tools.length > most) session.letGo(session.numberOf(0));
        state().most = most;
        actions.changed(true);
      });
    for (const mode of ['hold', 'sphere'] as const)
      byId(`mode-${mode}`, HTMLButtonElement).addEventListener('click', () => actions.setMode(mode));
    this.repeating('push', 1);
    this.repeating('pull', -1);
    byId('let-go', HTMLButtonElement).addEventListener('click', () => hands.letGo());
    byId('whole', HTMLButtonElement).addEventListener('click', () => actions.wholeBody());
  }

  /** A step at a press or a key, more while the button is held. */
  private repeating(id: string, steps: number): void {
    const button = byId(id, HTMLButtonElement);
    let timer = 0, repeated = false;
    button.addEventListener('pointerdown', () => {
      const begin = performance.now();
      window.clearInterval(timer);
      repeated = false;
      timer = window.setInterval(() => {
        if (performance.now() - begin < 300) return;
        repeated = true;
        this.hands.move([0, 0, steps / 2]);
      }, 50);
    });
    for (const end of ['pointerup', 'pointercancel', 'pointerleave', 'blur'] as const)
      button.addEventListener(end, () => window.clearInterval(timer));
    button.addEventListener('click', () => {
      if (!repeated) this.hands.move([0, 0, steps]);
      repeated = false;
    });
  }

  private radiusOf(value: number): number {
    return (0.02 + 0.0028 * value) * this.actions.session.bounds.radius;
  }
  /** [m] */
  get stepLength(): number {
    const millimetres = Number(this.step.value);
    return millimetres > 0 && millimetres <= 1000 ? millimetres / 1e3 : this.actions.session.limit / 40;
  }

  /** Lists of a new model. */
  fill(): void {
    const { runtime, maps } = this.actions.session, { info } = runtime.model;
    const option = (value: string, text: string) => Object.assign(document.createElement('option'), { value, textContent: text });
    this.map.replaceChildren(option('none', 'Tissue'), ...maps.map(({ name, title }) => option(name, title)));
    const percent = (x: number) => `${significant(100 * x, 2)} %`;
    this.level.replaceChildren(...runtime.levels.map((level, i) => option(String(i),
      `${i === runtime.levels.length - 1 ? 'full model' : `level ${i}`}${level.errorForce > 0 ? `, error ${percent(level.errorForce)}` : ''}`)));
    this.level.disabled = runtime.levels.length < 2;
    this.step.value = significant(1e3 * info.maxDisplacement / 20, 2);
    byId('mode-sphere', HTMLButtonElement).disabled = !runtime.hasContact;
  }
  show(): void {
    const { state, runtime } = this.actions.session, { info } = runtime.model;
    document.body.dataset['mode'] = state.mode;
    for (const [key, id] of Object.entries(flags) as [Flag, string][]) byId(id, HTMLInputElement).checked = state[key];
    byId('grasp', HTMLInputElement).checked = state.sphere.grasp;
    for (const most of [1, 2]) byId(`most-${most}`, HTMLElement).setAttribute('aria-pressed', String(state.most === most));
    for (const mode of ['hold', 'sphere']) byId(`mode-${mode}`, HTMLElement).setAttribute('aria-pressed', String(state.mode === mode));
    this.map.value = state.map;
    const level = state.level ?? runtime.levels.length - 1, stated = runtime.levels[level];
    this.level.value = String(level);
    setText(byId('level-note', HTMLElement), runtime.body ? 'Of maps and fields; the reduced body has no levels.' : stated && stated.errorForce > 0
      ? `Stated error inside the trained range: ${significant(100 * stated.errorForce, 2)} % of the largest force, ${significant(100 * stated.errorDisplacement, 2)} % of the largest displacement.`
      : 'This model states no error of its levels.');
    byId('palpation-row', HTMLElement).hidden = state.map !== 'palpation';
    const { palpation, subdivision, radius, friction } = this.ranges;
    palpation.value = String(Math.round((100 * state.palpationDepth) / info.maxDisplacement));
    setText(byId('palpation-value', HTMLElement), `${significant(1e3 * state.palpationDepth, 2)} mm`);
    subdivision.value = String(state.subdivision);
    setText(byId('subdivision-value', HTMLElement), String(state.subdivision));
    radius.value = String(Math.round((state.sphere.radius / this.actions.session.bounds.radius - 0.02) / 0.0028));
    setText(byId('radius-value', HTMLElement), `${significant(1e3 * state.sphere.radius, 2)} mm`);
    friction.value = String(state.sphere.friction);
    setText(byId('friction-value', HTMLElement), String(state.sphere.friction));
    setFacts(byId('model-facts', HTMLElement), [
      ['Family', info.family],
      ['Surface nodes, that can be held', `${new Set(info.triangles).size}, ${info.activeNodes.length}`],
      ['Trained to at most', `${significant(1e3 * info.maxDisplacement, 3)} mm`],
    ]);
  }
}
