// The body of the report: errors as colours, and the worst cases as the finite elements and the model displace it, side
// by side under one camera.
import { Mesh, MeshBasicMaterial, SphereGeometry } from 'three';
import { BodyPicture, held, unknown } from '../../shared/src/body_picture.js';
import { boundsOf, framing, moved, shifted, turned, type Camera } from '../../shared/src/camera.js';
import { coloursOf } from '../../shared/src/colour_maps.js';
import { Legend, type Scale } from '../../shared/src/legend.js';
import { roundedUp } from '../../shared/src/numbers.js';
import { Overlay } from '../../shared/src/overlay.js';
import { listenToPointers } from '../../view/src/pointer.js';
import type { BodyCase, BodyData } from './data.js';

interface Shown {
  readonly scale: Scale;
  /** by point */
  readonly values: Float64Array;
  readonly known: Float64Array;
}

class Pane {
  readonly element = document.createElement('figure');
  readonly canvas = document.createElement('canvas');
  readonly caption = document.createElement('figcaption');
  readonly picture: BodyPicture;
  /** where the tool is */
  private readonly tool: Mesh;

  constructor(parent: HTMLElement, data: BodyData) {
    this.element.className = 'pane';
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute('role', 'img');
    this.element.append(this.canvas, this.caption);
    parent.append(this.element);
    this.picture = new BodyPicture(this.canvas);
    this.picture.setSurface(data.points_m.length / 3, Int32Array.from(data.triangles));
    this.picture.flatLight = true;
    this.tool = new Mesh(new SphereGeometry(0.02 * boundsOf(data.points_m).radius), new MeshBasicMaterial({ color: 0xf5a800, depthTest: false, transparent: true }));
    this.picture.objects.add(this.tool);
  }
  show(data: BodyData, displacement: readonly number[] | null, { values, known, scale }: Shown, caption: string, touched = -1): void {
    const { positions, colours } = this.picture;
    for (let i = 0; i < positions.length; ++i) positions[i] = data.points_m[i]! + (displacement?.[i] ?? 0);
    coloursOf(values, known, scale.low, scale.high, unknown, colours);
    for (let i = 3 * data.n_output; i < colours.length; ++i) colours[i] = held[i % 3]!;
    this.tool.visible = touched >= 0;
    if (touched >= 0) this.tool.position.fromArray(positions, 3 * touched);
    this.picture.positionsChanged();
    this.picture.coloursChanged();
    this.caption.textContent = caption;
    this.canvas.setAttribute('aria-label', `${caption}, coloured by ${scale.title}`);
  }
}

export class Body {
  private readonly left: Pane;
  private readonly right: Pane;
  private readonly legend = new Legend();
  private readonly overlay = new Overlay();
  private readonly radius: number;
  private readonly maps: readonly { name: string; shown: Shown }[];
  private readonly choice = document.createElement('select');
  private camera: Camera;
  private scheduled = 0;

  constructor(private readonly root: HTMLElement, private readonly data: BodyData) {
    const n = data.points_m.length / 3, bounds = boundsOf(data.points_m);
    this.radius = bounds.radius;
    const map = (title: string, rows: readonly (readonly [number, number])[], note: string): Shown => {
      const values = new Float64Array(n), known = new Float64Array(n);
      for (const [at, value] of rows) {
        values[at] = value;
        known[at] = 1;
      }
      return { values, known, scale: { title, unit: 'fraction', low: 0, high: roundedUp(Math.max(...rows.map(([, value]) => value), 0)), ...(note ? { note } : {}) } };
    };
    this.maps = [
      { name: 'Mean error of the displacement', shown: map('Mean error of the displacement', data.displacement_error.map((e, i) => [i, e] as const), '') },
      { name: 'Mean error of the force at the probed nodes', shown: map('Mean error of the force', data.nodes.map(({ row, force_error }) => [row, force_error] as const), 'Grey: not probed') },
      ...(data.not_trained.some(([, share]) => share > 0)
        ? [{ name: 'Where the trained range ends early', shown: map('Share of the probe volume beyond the trained range', data.not_trained, 'Grey: no active node') }]
        : []),
    ];
    const label = document.createElement('label');
    label.textContent = 'Show ';
    this.maps.forEach(({ name }, i) => this.choice.append(new Option(name, `map ${i}`)));
    data.cases.forEach((state, i) => this.choice.append(new Option(`Case ${i + 1}: node ${state.node}, error of the force ${percent(state.force_error)}`, `case ${i}`)));
    label.append(this.choice);
    const panes = document.createElement('div');
    panes.className = 'panes';
    const foot = document.createElement('div');
    foot.className = 'foot';
    foot.append(this.legend.element, this.overlay.element);
    const help = document.createElement('p');
    help.className = 'key';
    help.textContent = 'Drag to turn, wheel to come closer, right button to shift.';
    root.append(label, panes, foot, help);
    this.left = new Pane(panes, data);
    this.right = new Pane(panes, data);
    this.right.element.hidden = true;
    this.resize();
    this.camera = framing(data.points_m, this.left.picture.size);
    for (const pane of [this.left, this.right]) {
      listenToPointers(pane.canvas, {
        grab: () => null, across: () => {}, away: () => {}, release: () => {}, lastTool: null,
        turn: (dx, dy) => this.look(turned(this.camera, -0.008 * dx, 0.008 * dy)),
        shift: (dx, dy) => this.look(shifted(this.camera, pane.picture.size, dx, dy)),
        zoom: (factor) => this.look(moved(this.camera, factor, this.radius)),
      });
      pane.canvas.addEventListener('keydown', (event) => {
        const turn = { ArrowLeft: [-24, 0], ArrowRight: [24, 0], ArrowUp: [0, -24], ArrowDown: [0, 24] }[event.key];
        if (!turn) return;
        this.look(turned(this.camera, -0.008 * turn[0]!, 0.008 * turn[1]!));
        event.preventDefault();
      });
    }
    this.choice.addEventListener('change', () => this.show(this.choice.value));
    new ResizeObserver(() => {
      this.resize();
      this.draw();
    }).observe(panes);
    addEventListener('beforeprint', () => this.render());
    this.show('map 0');
  }

  /** "map 0" or "case 3" */
  show(what: string): void {
    const [kind, number] = what.split(' '), at = Number(number);
    this.choice.value = what;
    const state = kind === 'case' ? this.data.cases[at] : undefined;
    const other = this.right.element.hidden === (state !== undefined);
    this.right.element.hidden = !state;
    if (state) this.showCase(state);
    else {
      const { shown, name } = this.maps[at]!;
      this.left.show(this.data, null, shown, name);
      this.legend.show(shown.scale);
    }
    this.resize();
    if (other) this.camera = framing(this.data.points_m, this.left.picture.size);
    this.draw();
  }
  private showCase(state: BodyCase): void {
    const n = this.data.points_m.length / 3, values = new Float64Array(n), known = new Float64Array(n).fill(1);
    for (let i = 0; i < this.data.n_output; ++i)
      values[i] = Math.hypot(...[0, 1, 2].map((k) => state.model_m[3 * i + k]! - state.finite_elements_m[3 * i + k]!));
    const shown: Shown = { values, known, scale: { title: 'Distance between model and finite elements', unit: 'm', low: 0, high: roundedUp(Math.max(...values)) } };
    const depth = `node ${state.node} displaced by ${(1e3 * Math.hypot(...state.displacement_m)).toPrecision(3)} mm`;
    this.left.show(this.data, state.finite_elements_m, shown, `Finite elements, ${depth}`, state.row);
    this.right.show(this.data, state.model_m, shown, `Model, ${depth}`, state.row);
    this.legend.show(shown.scale);
  }
  private look(camera: Camera): void {
    this.camera = camera;
    this.draw();
  }
  private resize(): void {
    for (const { canvas, picture, element } of [this.left, this.right])
      if (!element.hidden) picture.resize(canvas.clientWidth, canvas.clientHeight);
  }
  private draw(): void {
    if (this.scheduled === 0) this.scheduled = requestAnimationFrame(() => this.render());
  }
  private render(): void {
    this.scheduled = 0;
    for (const { element, picture } of [this.left, this.right]) if (!element.hidden) picture.render(this.camera);
    this.overlay.show(this.camera, this.left.picture.size);
  }
  scrollTo(): void {
    this.root.scrollIntoView({ block: 'center' });
  }
}

const percent = (x: number): string => `${(100 * x).toPrecision(3)} %`;
