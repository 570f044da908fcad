// What is drawn beside the body: tools, forces, nodes and the sphere.
import {
  ConeGeometry, CylinderGeometry, Group, InstancedMesh, Matrix4, Mesh, MeshBasicMaterial, MeshStandardMaterial,
  SphereGeometry, Vector3, type Material,
} from 'three';
import { norm, unit, type V3 } from '../../shared/src/vectors.js';

const amber = 0xf2a900, ink = 0x0e2a33;
const upwards = new Vector3(0, 1, 0);

/** An arrow that is drawn over the body. */
class Arrow {
  readonly group = new Group();
  private readonly shaft: Mesh;
  private readonly head: Mesh;

  constructor(color: number, private readonly thickness: number) {
    const material = new MeshBasicMaterial({ color, depthTest: false, transparent: true });
    this.shaft = new Mesh(new CylinderGeometry(thickness, thickness, 1, 16), material);
    this.head = new Mesh(new ConeGeometry(3 * thickness, 8 * thickness, 24), material);
    this.shaft.renderOrder = this.head.renderOrder = 5;
    this.group.add(this.shaft, this.head);
    this.group.visible = false;
  }
  show(from: V3, along: V3): void {
    const length = norm(along), head = Math.min(8 * this.thickness, length);
    this.group.visible = length > 1e-9;
    if (!this.group.visible) return;
    this.group.position.set(...from);
    this.group.quaternion.setFromUnitVectors(upwards, new Vector3(...unit(along)));
    this.shaft.scale.y = Math.max(1e-9, length - head);
    this.shaft.position.y = (length - head) / 2;
    this.head.scale.setScalar(head / (8 * this.thickness));
    this.head.position.y = length - head / 2;
  }
  hide(): void {
    this.group.visible = false;
  }
}

export class Marks {
  private readonly forces: Arrow[];
  private readonly parts: Arrow[];
  private readonly tools: Mesh[];
  private readonly cursor: Mesh;
  private readonly sphere: Mesh;
  private readonly dots: InstancedMesh;

  /** @param radius  of the body [m]; nodes that can be held at most */
  constructor(private readonly parent: Group, radius: number, nDots: number) {
    const solid = (color: number, options = {}) => new MeshBasicMaterial({ color, ...options });
    const add = (mesh: Mesh, order: number): Mesh => {
      mesh.visible = false;
      mesh.renderOrder = order;
      parent.add(mesh);
      return mesh;
    };
    const ball = (material: Material, r: number, order: number) => add(new Mesh(new SphereGeometry(r, 24, 16), material), order);
    this.dots = new InstancedMesh(new SphereGeometry(0.0085 * radius, 10, 8), solid(ink), Math.max(1, nDots));
    this.dots.count = 0;
    this.dots.frustumCulled = false;
    parent.add(this.dots);
    this.cursor = ball(solid(0xffffff), 0.018 * radius, 1);
    this.tools = [0, 1].map(() => ball(solid(amber, { depthTest: false, transparent: true, opacity: 0.92 }), 0.022 * radius, 4));
    this.sphere = ball(new MeshStandardMaterial({ color: 0x7fb7c9, roughness: 0.35, transparent: true, opacity: 0.6, depthWrite: false }), 1, 3);
    const arrows = (n: number, colors: readonly number[], thickness: number) => Array.from({ length: n }, (_, i) => {
      const arrow = new Arrow(colors[i % colors.length]!, thickness);
      parent.add(arrow.group);
      return arrow;
    });
    this.forces = arrows(2, [amber], 0.0085 * radius);
    this.parts = arrows(6, [0xc4443a, 0x3c8a4e, 0x4a78d0], 0.0055 * radius);
  }

  /** @param positions  n x 3, of the nodes that can be held; null: not shown */
  showDots(positions: Float32Array | null): void {
    this.dots.visible = positions !== null;
    if (!positions) return;
    const matrix = new Matrix4(), n = Math.min(positions.length / 3, this.dots.instanceMatrix.count);
    for (let i = 0; i < n; ++i)
      this.dots.setMatrixAt(i, matrix.setPosition(positions[3 * i]!, positions[3 * i + 1]!, positions[3 * i + 2]!));
    this.dots.count = n;
    this.dots.instanceMatrix.needsUpdate = true;
  }
  showCursor(at: V3 | null): void {
    this.cursor.visible = at !== null;
    if (at) this.cursor.position.set(...at);
  }
  /** @param metres  length of an arrow for 1 N */
  showForces(points: readonly V3[], forces: readonly V3[], metres: number, components: boolean, balls: boolean): void {
    this.forces.forEach((arrow, i) => {
      const at = points[i], force = forces[i];
      if (at && force) arrow.show(at, [force[0] * metres, force[1] * metres, force[2] * metres]);
      else arrow.hide();
      for (let k = 0; k < 3; ++k) {
        const part = this.parts[3 * i + k]!, along: [number, number, number] = [0, 0, 0];
        if (!at || !force || !components) part.hide();
        else {
          along[k] = force[k]! * metres;
          part.show(at, along);
        }
      }
      this.tools[i]!.visible = balls && at !== undefined;
      if (at) this.tools[i]!.position.set(...at);
    });
  }
  showSphere(center: V3 | null, radius: number): void {
    this.sphere.visible = center !== null;
    if (!center) return;
    this.sphere.position.set(...center);
    this.sphere.scale.setScalar(radius);
  }

  dispose(): void {
    this.parent.traverse((object) => {
      if (!(object instanceof Mesh)) return;
      (object as Mesh).geometry.dispose();
      ((object as Mesh).material as Material).dispose();
    });
    this.parent.clear();
  }
}

