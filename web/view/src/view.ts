// The page at work: draws a session when something changed, and keeps the address of the page up to date.
import { BodyPicture, held, tissue, unknown } from '../../shared/src/body_picture.js';
import { framing, project, type Camera, type Size } from '../../shared/src/camera.js';
import { coloursOf } from '../../shared/src/colour_maps.js';
import { Legend } from '../../shared/src/legend.js';
import { significant } from '../../shared/src/numbers.js';
import { Overlay } from '../../shared/src/overlay.js';
import { add, norm, row, scale, sub, zero, type V3 } from '../../shared/src/vectors.js';
import { Controls } from './controls.js';
import { byId, setText } from './dom.js';
import { drawnAt, Influence, type Follower } from './following.js';
import { Hands } from './hands.js';
import { listenToKeys } from './keyboard.js';
import { Marks } from './marks.js';
import { onSurface, type MapValues } from './maps.js';
import { listenToPointers } from './pointer.js';
import { Readouts } from './readouts.js';
import type { Session } from './session.js';
import { fragmentOf, type State } from './state.js';

export class View {
  readonly picture = new BodyPicture(byId('canvas', HTMLCanvasElement));
  readonly legend = new Legend();
  private readonly overlay = new Overlay();
  private readonly readouts = new Readouts();
  private readonly hands = new Hands(this);
  private readonly controls: Controls;
  private readonly stage = byId('stage', HTMLElement);
  private readonly labels = byId('labels', HTMLElement);
  private readonly status = byId('status', HTMLElement);
  private readonly problem = byId('problem', HTMLElement);
  private marks: Marks | null = null;
  private drawnSubdivision = -1;
  private moved = new Float32Array(0);
  private influence: Influence | null = null;
  /** of the arrows: the largest force so far [N] */
  private largestForce = 0;
  private scheduled = 0;
  private physics = true;
  private pictures = 0;
  private slow = 0;
  private addressTimer = 0;
  private address = '';
  camera!: Camera;

  constructor(public session: Session) {
    byId('foot', HTMLElement).append(this.legend.element, this.overlay.element);
    this.controls = new Controls(this, this.hands);
    listenToPointers(this.picture.canvas, this.hands);
    listenToKeys(this.picture.canvas, this.hands);
    new ResizeObserver(() => this.changed(false)).observe(this.stage);
    this.picture.canvas.addEventListener('webglcontextrestored', () => this.changed(true));
    this.open(session);
  }

  /** Shows another model. */
  open(session: Session): void {
    this.session = session;
    this.marks?.dispose();
    this.marks = new Marks(this.picture.objects, session.bounds.radius, session.runtime.active.size);
    this.drawnSubdivision = -1;
    this.largestForce = 0;
    this.picture.resize(this.stage.clientWidth, this.stage.clientHeight);
    this.camera = session.state.camera ?? framing(this.rest, this.picture.size);
    this.controls.fill();
    this.changed(true);
  }

  // ---- what hands and controls need -------------------------------------------------------------------------------

  get size(): Size {
    return this.picture.size;
  }
  /** displayed, and at rest: the same triangles, n x 3 */
  get positions(): Float32Array {
    return this.picture.positions;
  }
  get rest(): ArrayLike<number> {
    return this.session.runtime.surface(this.session.state.subdivision).points;
  }
  get triangles(): Int32Array {
    return this.session.runtime.surface(this.session.state.subdivision).triangles;
  }
  /** step of keys and buttons [m] */
  get step(): number {
    return this.controls.stepLength;
  }
  /** a sentence for people who do not see the picture */
  say(what: string): void {
    setText(this.status, what);
  }
  wholeBody(): void {
    this.camera = framing(this.rest, this.size);
    this.changed(false);
  }
  setMode(mode: State['mode']): void {
    this.session.setMode(mode);
    this.changed(true);
  }
  /** Draws soon. @param physics  tools moved: forces have to be computed */
  changed(physics: boolean): void {
    this.physics ||= physics;
    if (this.scheduled === 0) this.scheduled = requestAnimationFrame(() => this.draw());
  }

  // ---- drawing ----------------------------------------------------------------------------------------------------

  /** Everything that changed, now. */
  draw(): void {
    cancelAnimationFrame(this.scheduled);
    this.scheduled = 0;
    const { session, picture } = this, { state } = session;
    picture.resize(this.stage.clientWidth, this.stage.clientHeight);
    if (this.physics) session.update();
    this.physics = false;
    if (session.restless) this.changed(true);
    this.drawSurface();
    this.drawMarks();
    picture.showEdges = state.edges;
    picture.render(this.camera);
    this.overlay.show(this.camera, this.size);
    this.showLabels();
    this.problem.hidden = session.problem === null;
    if (session.problem) setText(this.problem, session.problem);
    byId('invitation', HTMLElement).hidden = state.tools.length > 0 || state.mode === 'sphere';
    this.readouts.show(session);
    this.controls.show();
    window.clearTimeout(this.slow);
    // The curve, which takes tenths of a second of a body, and the address of the page rest while things move fast.
    this.slow = window.setTimeout(() => this.settle(), session.runtime.body ? 500 : 60);
    if (++this.pictures % 4 === 0 && !session.runtime.body) this.readouts.showPlot(session);
  }
  private settle(): void {
    this.readouts.showPlot(this.session);
    window.clearTimeout(this.addressTimer);
    // Browsers allow 100 to 200 addresses in 10 to 30 s.
    this.addressTimer = window.setTimeout(() => this.writeAddress(), 340);
  }
  private writeAddress(): void {
    this.session.state.camera = this.camera;
    const address = fragmentOf(this.session.state);
    if (address === this.address) return;
    this.address = address;
    history.replaceState(null, '', address);
  }

  private drawSurface(): void {
    const { session, picture } = this, { state, runtime } = session, surface = runtime.surface(state.subdivision);
    if (this.drawnSubdivision !== state.subdivision) {
      picture.setSurface(surface.nVertices, surface.triangles);
      this.moved = new Float32Array(3 * surface.nVertices);
      this.drawnSubdivision = state.subdivision;
      this.influence = new Influence(surface, runtime.rows, runtime.model.info.outputNodes.length);
    }
    surface.deform(runtime.field, this.moved);
    const followers = this.followers();
    if (state.subdivision > 0 && followers.length > 0)
      surface.deform(this.influence!.followed(runtime.field, this.moved, followers), this.moved);
    const { positions } = picture, { points } = surface;
    for (let i = 0; i < positions.length; ++i) positions[i] = points[i]! + this.moved[i]!;
    picture.positionsChanged();
    this.colour(surface);
  }

  /** What the drawn surface has to follow: the points in the middle of tools, which a round tool moves farther than the mean. */
  private followers(): Follower[] {
    const { state, answer, runtime } = this.session;
    const places = state.mode === 'sphere' ? answer.touches.flatMap(({ held: place }) => place ?? [])
      : answer.warnings.includes('unsettled') ? [] : state.tools.map(({ place }) => place);
    return places.map((place) => ({ place, displacement: runtime.displacementAt(place) }));
  }
  /** Where a tool is in the picture; the drawn surface at rest is slightly smaller than the triangles of the model. */
  seen(tool: Follower): V3 {
    return add(drawnAt(this.rest, tool.place, this.session.runtime.rows), tool.displacement);
  }

  private colour(surface: { deform(field: Float64Array): Float32Array }): void {
    const { session, picture } = this, kind = session.maps.find(({ name }) => name === session.state.map);
    const { outputNodes } = session.runtime.model.info;
    const map: MapValues = kind ? kind.values(session.mapTools) : {
      // Without a map: what is fixed is dark.
      scale: { title: '', unit: '', low: 0, high: 1 },
      values: new Float64Array(outputNodes.length), known: new Float64Array(outputNodes.length).fill(1),
    };
    const { values, weights } = onSurface(surface, map);
    if (kind) coloursOf(values, weights, map.scale.low, map.scale.high, unknown, picture.colours);
    else {
      const { colours } = picture;
      for (let i = 0; i < weights.length; ++i)
        for (let k = 0; k < 3; ++k) colours[3 * i + k] = weights[i]! * tissue[k]! + (1 - weights[i]!) * held[k]!;
    }
    picture.coloursChanged();
    picture.flatLight = kind !== undefined;
    this.legend.show(kind ? map.scale : null);
  }

  /** Where the forces act, in the picture. */
  private forcePoints(): V3[] {
    const { session } = this;
    return session.state.mode === 'hold' ? session.state.tools.map((tool) => this.seen(tool)) : this.followers().map((tool) => this.seen(tool));
  }
  /** Length of an arrow for 1 N [m]; it shrinks when a larger force than before appears. */
  private arrowLength(): number {
    this.largestForce = Math.max(this.largestForce, ...this.session.answer.forces.map(norm));
    return this.largestForce > 0 ? (0.5 * this.session.bounds.radius) / this.largestForce : 0;
  }

  private drawMarks(): void {
    const { session } = this, { state, answer, runtime } = session, marks = this.marks!, { picture } = this;
    const hold = state.mode === 'hold';
    const points = this.forcePoints();
    marks.showForces(points, answer.forces, this.arrowLength(), state.components, hold);
    const at = (node: number) => row(picture.positions, runtime.rows.get(node)!);
    if (state.nodes && hold) {
      const dots = new Float32Array(3 * runtime.active.size);
      let i = 0;
      for (const node of runtime.active) dots.set(at(node), 3 * i++);
      marks.showDots(dots);
    } else marks.showDots(null);
    const focused = document.activeElement === this.picture.canvas && this.picture.canvas.matches(':focus-visible');
    marks.showCursor(hold && focused && runtime.active.has(session.cursor) ? at(session.cursor) : null);
    marks.showSphere(hold ? null : this.seenSphere(), state.sphere.radius);
  }

  /** The sphere, moved by as much as the drawn surface at rest differs from the triangles of the model. */
  private seenSphere(): V3 | null {
    const { session } = this, { center } = session.state.sphere, [touched] = this.followers();
    if (!center || !touched) return center;
    return add(center, sub(this.seen(touched), add(session.restPoint(touched.place), touched.displacement)));
  }

  /** Newtons beside the arrows. */
  private showLabels(): void {
    const { session } = this, points = this.forcePoints(), metres = this.arrowLength();
    while (this.labels.children.length < points.length) this.labels.append(document.createElement('span'));
    [...this.labels.children].forEach((label, i) => {
      const point = points[i], force = session.answer.forces[i] ?? zero;
      (label as HTMLElement).hidden = point === undefined;
      if (!point) return;
      const foot = project(this.camera, this.size, point), head = project(this.camera, this.size, add(point, scale(metres, force)));
      const length = Math.hypot(head.x - foot.x, head.y - foot.y) || 1;
      const tip = { x: head.x + (34 * (head.x - foot.x)) / length, y: head.y + (18 * (head.y - foot.y)) / length };
      (label as HTMLElement).style.left = `${Math.min(this.size.width - 40, Math.max(40, tip.x)).toFixed(0)}px`;
      (label as HTMLElement).style.top = `${Math.min(this.size.height - 20, Math.max(62, tip.y)).toFixed(0)}px`;
      setText(label, `${significant(norm(force), 3)} N`);
    });
  }
}
