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
import { Discs, errorScale, meanOf, pale } from './between_nodes.js';
import type { BodyCase, BodyData, PointErrors } from './data.js';

interface Shown {
  readonly scale: Scale;
  /** by point */
  readonly values: Float64Array;
  readonly known: Float64Array;
  readonly discs?: PointErrors;
}
/** What a pane shows. */
interface Drawing {
  readonly shown: Shown;
  readonly caption: string;
  /** of the points, n x 3 [m]; none: at rest */
  readonly displacement?: readonly number[];
  /** row of the touched point */
  readonly touched?: number;
}

class Pane {
  readonly element = document.createElement('figure');
  readonly canvas = document.createElement('canvas');
  readonly caption = document.createElement('figcaption');
  readonly picture: BodyPicture;
  /** where the tool is */
  private readonly tool: Mesh;
  private readonly discs: Discs | null;

  constructor(parent: HTMLElement, private readonly data: BodyData) {
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
    this.discs = data.between_nodes && new Discs(data, data.between_nodes);
    if (this.discs) this.picture.objects.add(this.discs.group);
  }
  show({ shown: { values, known, scale, discs }, caption, displacement, touched = -1 }: Drawing): void {
    const { positions, colours } = this.picture, { data } = this;
    for (let i = 0; i < positions.length; ++i) positions[i] = data.points_m[i]! + (displacement?.[i] ?? 0);
    coloursOf(values, known, scale.low, scale.high, discs ? pale : unknown, colours);
    for (let i = 3 * data.n_output; i < colours.length; ++i) colours[i] = held[i % 3]!;
    this.tool.visible = touched >= 0;
    if (touched >= 0) this.tool.position.fromArray(positions, 3 * touched);
    if (this.discs) this.discs.group.visible = discs !== undefined;
    if (discs) this.discs?.show(discs, scale);
    this.picture.positionsChanged();
    this.picture.coloursChanged();
    this.caption.textContent = caption;
    this.canvas.setAttribute('aria-label', `${caption}, coloured by ${scale.title}`);
  }
}

export class Body {
  private readonly panes: readonly Pane[];
  private readonly legend = new Legend();
  private readonly overlay = new Overlay();
  private readonly radius: number;
  private readonly maps: readonly { name: string; drawings: readonly Drawing[] }[];
  private readonly choice = document.createElement('select');
  private camera: Camera;
  private scheduled = 0;

  constructor(private readonly root: HTMLElement, private readonly data: BodyData) {
    const n = data.points_m.length / 3, bounds = boundsOf(data.points_m);
    this.radius = bounds.radius;
    const map = (name: string, title: string, rows: readonly (readonly [number, number])[], note = '') => {
      const values = new Float64Array(n), known = new Float64Array(n);
      for (const [at, value] of rows) {
        values[at] = value;
        known[at] = 1;
      }
      const scale = { title, unit: 'fraction', low: 0, high: roundedUp(Math.max(...rows.map(([, value]) => value), 0)), ...(note ? { note } : {}) };
      return { name, drawings: [{ shown: { values, known, scale }, caption: name }] };
    };
    const between = data.between_nodes, grey = new Float64Array(n);
    this.maps = [
      map('Mean error of the displacement', 'Mean error of the displacement', data.displacement_error.map((e, i) => [i, e] as const)),
      map('Mean error of the force at the probed nodes', 'Mean error of the force', data.nodes.map(({ row, force_error }) => [row, force_error] as const), 'Grey: not probed'),
      ...(between
        ? [{ name: errorScale.title,
          drawings: between.predictors.map((discs) => ({
            shown: { values: grey, known: grey, scale: errorScale, discs },
            caption: `${discs.name}: mean ${percent(meanOf(discs.force_error))}`,
          })) }]
        : []),
      ...(data.not_trained.some(([, share]) => share > 0)
        ? [map('Where the trained range ends early', 'Share of the probe volume beyond the trained range', data.not_trained, 'Grey: no active node')]
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
    this.panes = Array.from({ length: Math.max(2, between?.predictors.length ?? 0) }, () => new Pane(panes, data));
    this.panes.slice(1).forEach(({ element }) => { element.hidden = true; });
    this.resize();
    this.camera = framing(data.points_m, this.panes[0]!.picture.size);
    for (const pane of this.panes) {
      listenToPointers(pane.canvas, {
        grab: () => null, across: () => {}, away: () => {},
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
    const drawings = state ? this.ofCase(state) : this.maps[at]!.drawings;
    const before = this.shownPanes().length;
    this.panes.forEach((pane, i) => {
      pane.element.hidden = i >= drawings.length;
      if (i < drawings.length) pane.show(drawings[i]!);
    });
    this.legend.show(drawings[0]!.shown.scale);
    this.resize();
    if (before !== drawings.length) this.camera = framing(this.data.points_m, this.panes[0]!.picture.size);
    this.draw();
  }
  private ofCase(state: BodyCase): Drawing[] {
    const n = this.data.points_m.length / 3, values = new Float64Array(n), known = new Float64Array(n).fill(1);
    for (let i = 0; i < this.data.n_output; ++i)
      values[i] = Math.hypot(...[0, 1, 2].map((k) => state.model_m[3 * i + k]! - state.finite_elements_m[3 * i + k]!));
    const shown: Shown = { values, known, scale: { title: 'Distance between model and finite elements', unit: 'm', low: 0, high: roundedUp(Math.max(...values)) } };
    const depth = `node ${state.node} displaced by ${(1e3 * Math.hypot(...state.displacement_m)).toPrecision(3)} mm`, touched = state.row;
    return [
      { shown, displacement: state.finite_elements_m, caption: `Finite elements, ${depth}`, touched },
      { shown, displacement: state.model_m, caption: `Model, ${depth}`, touched },
    ];
  }
  private shownPanes(): Pane[] {
    return this.panes.filter(({ element }) => !element.hidden);
  }
  private look(camera: Camera): void {
    this.camera = camera;
    this.draw();
  }
  private resize(): void {
    for (const { canvas, picture } of this.shownPanes()) picture.resize(canvas.clientWidth, canvas.clientHeight);
  }
  private draw(): void {
    if (this.scheduled === 0) this.scheduled = requestAnimationFrame(() => this.render());
  }
  private render(): void {
    this.scheduled = 0;
    for (const { picture } of this.shownPanes()) picture.render(this.camera);
    this.overlay.show(this.camera, this.panes[0]!.picture.size);
  }
  scrollTo(): void {
    this.root.scrollIntoView({ block: 'center' });
  }
}

const percent = (x: number): string => `${(100 * x).toPrecision(3)} %`;
