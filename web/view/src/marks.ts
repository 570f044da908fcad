// What is drawn beside the body: tools, forces, probed points and spheres.
import {
  ConeGeometry, CylinderGeometry, Group, InstancedMesh, Matrix4, Mesh, MeshBasicMaterial, MeshStandardMaterial,
  SphereGeometry, Vector3, type Material,
} from 'three';
import { norm, scale, unit, type V3 } from '../../shared/src/vectors.js';

const amber = 0xf2a900, ink = 0x0e2a33;
const upwards = new Vector3(0, 1, 0);

/** An arrow that is drawn over the body. */
class Arrow {
  readonly group = new Group();
  private readonly shaft: Mesh;
  private readonly head: Mesh;

  constructor(private readonly thickness: number) {
    const material = new MeshBasicMaterial({ color: amber, depthTest: false, transparent: true });
    this.shaft = new Mesh(new CylinderGeometry(thickness, thickness, 1, 16), material);
    this.head = new Mesh(new ConeGeometry(3 * thickness, 8 * thickness, 24), material);
    this.shaft.renderOrder = this.head.renderOrder = 5;
    this.group.add(this.shaft, this.head);
  }
  show(from: V3, along: V3): void {
    const length = norm(along), head = Math.min(8 * this.thickness, length);
    this.group.visible = length > 1e-9;
    this.group.position.set(...from);
    this.group.quaternion.setFromUnitVectors(upwards, new Vector3(...unit(along)));
    this.shaft.scale.y = Math.max(1e-9, length - head);
    this.shaft.position.y = (length - head) / 2;
    this.head.scale.setScalar(head / (8 * this.thickness));
    this.head.position.y = length - head / 2;
  }
}

export class Marks {
  private readonly arrows: Arrow[];
  private readonly tools: Mesh[];
  private readonly spheres: Mesh[];
  private readonly dots: InstancedMesh;

  /** @param radius  of the body [m]. @param nDots  how many dots at most */
  constructor(parent: Group, radius: number, nDots: number) {
    const balls = (material: Material, r: number, order: number) => [0, 1].map(() => {
      const mesh = new Mesh(new SphereGeometry(r, 32, 20), material);
      mesh.renderOrder = order;
      parent.add(mesh);
      return mesh;
    });
    this.dots = new InstancedMesh(new SphereGeometry(0.0085 * radius, 10, 8), new MeshBasicMaterial({ color: ink }), nDots);
    this.dots.frustumCulled = false;
    parent.add(this.dots);
    this.tools = balls(new MeshBasicMaterial({ color: amber, depthTest: false, transparent: true, opacity: 0.92 }), 0.022 * radius, 4);
    this.spheres = balls(new MeshStandardMaterial({ color: 0x7fb7c9, roughness: 0.35, transparent: true, opacity: 0.6, depthWrite: false }), 1, 3);
    this.arrows = [0, 1].map(() => new Arrow(0.0085 * radius));
    for (const { group } of this.arrows) parent.add(group);
  }

  showDots(points: readonly V3[]): void {
    this.dots.count = points.length;
    points.forEach((point, i) => this.dots.setMatrixAt(i, new Matrix4().setPosition(...point)));
    this.dots.instanceMatrix.needsUpdate = true;
  }
  /** @param metres  length of an arrow for 1 N */
  showForces(points: readonly V3[], forces: readonly V3[], metres: number): void {
    this.arrows.forEach((arrow, i) => arrow.show(points[i] ?? [0, 0, 0], scale(metres, forces[i] ?? [0, 0, 0])));
  }
  showTools(points: readonly V3[]): void {
    this.put(this.tools, points, 1);
  }
  showSpheres(centers: readonly V3[], radius: number): void {
    this.put(this.spheres, centers, radius);
  }
  private put(balls: readonly Mesh[], at: readonly V3[], size: number): void {
    balls.forEach((ball, i) => {
      ball.visible = at[i] !== undefined;
      ball.position.set(...(at[i] ?? [0, 0, 0] as V3));
      ball.scale.setScalar(size);
    });
  }
}
