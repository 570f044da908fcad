// The page at work: draws a session when something changed.
import type { Place } from '../../runtime/src/index.js';
import { BodyPicture, unknown } from '../../shared/src/body_picture.js';
import { facing, framing, outsideOf, project, type Camera, type Size } from '../../shared/src/camera.js';
import { coloursOf } from '../../shared/src/colour_maps.js';
import { Legend } from '../../shared/src/legend.js';
import { significant } from '../../shared/src/numbers.js';
import { Overlay } from '../../shared/src/overlay.js';
import { add, norm, row, scale, sub, zero, type V3 } from '../../shared/src/vectors.js';
import { Controls } from './controls.js';
import { byId, setText } from './dom.js';
import { Hands } from './hands.js';
import { Marks } from './marks.js';
import { onSurface } from './maps.js';
import { partColours, partsLegend } from './parts.js';
import { meanAt } from './places.js';
import { listenToPointers } from './pointer.js';
import { digitsOf, Readouts } from './readouts.js';
import type { Session, Tool } from './session.js';

/** Triangles that are drawn at most. */
const mostTriangles = 200_000;
/** Least distance of the eye from the surface, in radii of the body. */
const leastDistance = 0.6;

export class View {
  readonly picture = new BodyPicture(byId('canvas', HTMLCanvasElement));
  camera: Camera;
  private readonly stage = byId('stage', HTMLElement);
  private readonly labels = byId('labels', HTMLElement);
  private readonly hint = byId('hint', HTMLElement);
  private readonly legend = new Legend();
  private readonly parts: HTMLElement;
  private readonly partColours: Float32Array;
  private readonly overlay = new Overlay();
  private readonly readouts = new Readouts();
  private readonly controls: Controls;
  private readonly marks: Marks;
  private readonly surface;
  private moved: Float32Array;
  /** of the arrows: the largest force so far [N] */
  private largestForce = 0;
  private scheduled = 0;
  private physics = true;
  private slow = 0;

  constructor(readonly session: Session) {
    const { runtime } = session, { triangles } = runtime.model.info;
    this.surface = runtime.model.surface([2, 1, 0].find((levels) => (triangles.length / 3) * 4 ** levels <= mostTriangles) ?? 0);
    this.moved = new Float32Array(this.surface.points.length);
    this.picture.setSurface(this.surface.nVertices, this.surface.triangles);
    this.picture.resize(this.stage.clientWidth, this.stage.clientHeight);
    this.camera = framing(this.rest, this.size, facing(this.rest, [...runtime.active].map((node) => runtime.point(node))));
    this.marks = new Marks(this.picture.objects, session.bounds.radius, runtime.active.size);
    this.parts = partsLegend(runtime);
    this.partColours = partColours(this.surface, runtime);
    byId('foot', HTMLElement).append(this.parts, this.legend.element, this.overlay.element);
    const hands = new Hands(this);
    this.controls = new Controls(this, hands);
    listenToPointers(this.picture.canvas, hands);
    new ResizeObserver(() => this.resized()).observe(this.stage);
    this.picture.canvas.addEventListener('webglcontextrestored', () => this.changed(true));
    this.invite();
    this.draw();
  }

  get size(): Size {
    return this.picture.size;
  }
  /** of the drawn surface now, and at rest: n x 3 [m] */
  get positions(): Float32Array {
    return this.picture.positions;
  }
  get rest(): Float32Array {
    return this.surface.points;
  }
  get triangles(): Int32Array {
    return this.surface.triangles;
  }
  /** A sentence above the picture; it disappears when a tool is taken. */
  say(what: string): void {
    setText(this.hint, what);
    this.hint.hidden = what === '';
  }
  /** Says what can be done. */
  invite(): void {
    this.say(this.session.mode === 'hold' ? 'Drag the body to pull it. Drag beside it to turn the view.'
      : 'Drag a sphere, or put it on the body. The wheel, or Push, moves it away from you.');
  }
  look(camera: Camera): void {
    this.camera = camera;
    this.changed(false);
  }
  wholeBody(): void {
    this.look(framing(this.rest, this.size));
  }
  /** The body stays as large in the window as before. */
  private resized(): void {
    const before = framing(this.rest, this.size, this.camera);
    if (!this.picture.resize(this.stage.clientWidth, this.stage.clientHeight)) return;
    const after = framing(this.rest, this.size, this.camera), { target, distance } = this.camera;
    this.look({ ...this.camera, target: add(target, sub(after.target, before.target)), distance: (distance * after.distance) / before.distance });
  }
  /** Draws soon. @param physics  tools moved: forces have to be computed */
  changed(physics: boolean): void {
    this.physics ||= physics;
    if (this.scheduled === 0) this.scheduled = requestAnimationFrame(() => this.draw());
  }

  /** Everything that changed, now. */
  draw(): void {
    cancelAnimationFrame(this.scheduled);
    this.scheduled = 0;
    const { session } = this;
    if (this.physics || session.restless) session.update(this.physics);
    this.physics = false;
    if (session.restless) this.changed(false);
    this.drawSurface();
    this.camera = outsideOf(this.camera, this.positions, leastDistance * session.bounds.radius);
    this.drawMarks();
    this.picture.render(this.camera);
    this.overlay.show(this.camera, this.size);
    this.showLabels();
    if (session.problem) this.say(session.problem);
    this.readouts.show(session);
    this.controls.show();
    window.clearTimeout(this.slow);
    this.slow = window.setTimeout(() => this.readouts.showPlot(session), 60);
  }

  private drawSurface(): void {
    const { session, surface, positions } = this, { points } = surface;
    surface.deform(session.runtime.field, this.moved);
    this.follow();
    for (let i = 0; i < positions.length; ++i) positions[i] = points[i]! + this.moved[i]!;
    this.picture.positionsChanged();
    this.colour();
  }
  /** Loop's scheme smooths displacements, so that the drawn surface lags behind held places. It is drawn with a field that is
   * changed at their nodes until it follows; each pass leaves less than half of what was missing. */
  private follow(): void {
    const { runtime } = this.session, field = runtime.field.slice(), places = this.heldPlaces();
    for (let pass = 0; pass < 6 && places.length > 0; ++pass) {
      for (const place of places) {
        const missing = sub(runtime.displacementAt(place), this.drawnAt(this.moved, place));
        const change = scale(1.6 / place.weights.reduce((sum, w) => sum + w * w, 0), missing);
        place.nodes.forEach((node, i) => {
          const at = 3 * runtime.rows.get(node)!;
          for (let k = 0; k < 3 && at < field.length; ++k) field[at + k]! += place.weights[i]! * change[k]!;
        });
      }
      this.surface.deform(field, this.moved);
    }
  }
  /** The places that tools hold, or that spheres touch. */
  private heldPlaces(): Place[] {
    const { session } = this;
    return session.mode === 'hold' ? session.held.map(({ place }) => place) : session.answer.touches.flatMap(({ held }) => held ?? []);
  }
  /** A quantity of the drawn surface at a place: its first vertices are the nodes. */
  private drawnAt(values: ArrayLike<number>, place: Place): V3 {
    return meanAt(place, (node) => row(values, this.session.runtime.rows.get(node)!));
  }
  private colour(): void {
    const { session, picture, surface } = this, kind = session.maps.find(({ name }) => name === session.map);
    const map = kind?.values(session.mode === 'hold' ? session.held : session.touching ? null : []);
    if (map) {
      const { values, weights } = onSurface(surface, map);
      coloursOf(values, weights, map.scale.low, map.scale.high, unknown, picture.colours);
    } else picture.colours.set(this.partColours);
    picture.coloursChanged();
    picture.flatLight = kind !== undefined;
    this.legend.show(map?.scale ?? null);
    this.parts.hidden = kind !== undefined;
  }

  /** Where a tool is in the picture; the drawn surface at rest is slightly smaller than the triangles of the model. */
  seen({ place, at }: Tool): V3 {
    return place ? add(this.drawnAt(this.rest, place), at) : at;
  }
  /** Spheres are moved by as much as the drawn surface differs from the triangles of the model where they touch it. */
  private seenSpheres(): V3[] {
    const { session } = this, { touches } = session.answer;
    return session.mode === 'hold' ? [] : session.tools.map(({ at }, i) => {
      const place = touches[i]?.held;
      return place ? add(at, sub(this.drawnAt(this.rest, place), session.restPoint(place))) : at;
    });
  }
  private drawMarks(): void {
    const { session, marks } = this, hold = session.mode === 'hold';
    const points = this.forcePoints();
    marks.showForces(points, session.answer.forces, this.arrowLength());
    marks.showTools(hold ? points : []);
    marks.showSpheres(this.seenSpheres(), session.sphere.radius);
    const { active, rows } = session.runtime;
    marks.showDots(hold && session.probedOnly ? [...active].map((node) => row(this.positions, rows.get(node)!)) : []);
  }
  /** Where the forces act, in the picture: at tools, or at the nearest points of spheres. */
  private forcePoints(): V3[] {
    const { session } = this, { radius } = session.sphere;
    if (session.mode === 'hold') return session.tools.map((tool) => this.seen(tool));
    return this.seenSpheres().map((center, i) => add(center, scale(-radius, row(session.answer.touches[i]?.normal ?? zero, 0))));
  }
  /** Length of an arrow for 1 N [m]; it shrinks when a larger force than before appears. */
  private arrowLength(): number {
    this.largestForce = Math.max(this.largestForce, ...this.session.answer.forces.map(norm));
    return this.largestForce > 0 ? (0.5 * this.session.bounds.radius) / this.largestForce : 0;
  }
  /** Newtons beside the arrows. */
  private showLabels(): void {
    const { forces, bounds } = this.session.answer, points = this.forcePoints(), metres = this.arrowLength();
    [...this.labels.children].forEach((child, i) => {
      const label = child as HTMLElement, point = points[i], force = forces[i] ?? zero;
      label.hidden = !point || norm(force) === 0;
      if (!point) return;
      const foot = project(this.camera, this.size, point), head = project(this.camera, this.size, add(point, scale(metres, force)));
      const length = Math.hypot(head.x - foot.x, head.y - foot.y) || 1, within = (x: number, most: number) => Math.min(most - 40, Math.max(40, x));
      label.style.left = `${within(head.x + (34 * (head.x - foot.x)) / length, this.size.width).toFixed(0)}px`;
      label.style.top = `${within(head.y + (18 * (head.y - foot.y)) / length, this.size.height).toFixed(0)}px`;
      setText(label, `${significant(norm(force), digitsOf(norm(force), bounds[i] ?? null))} N`);
    });
  }
}
