// Discs on the surface where tools between nodes were compared, coloured by the error of a predictor. A ring marks the
// places where the predictor warns.
import { CircleGeometry, Color, Group, InstancedMesh, Matrix4, MeshBasicMaterial, Quaternion, RingGeometry, Vector3 } from 'three';
import { boundsOf } from '../../shared/src/camera.js';
import { linearColour, type Rgb } from '../../shared/src/colour_maps.js';
import { placeOn, type Scale } from '../../shared/src/legend.js';
import { add, cross, row, scale, sub, unit, type V3 } from '../../shared/src/vectors.js';
import type { BetweenNodes, BodyData, PointErrors } from './data.js';

/** Colour of the body below them, in linear light. */
export const pale: Rgb = [0.62, 0.62, 0.62];
export const meanOf = (values: readonly number[]): number => values.reduce((a, b) => a + b, 0) / values.length;

/** The same for all predictors and bodies, so that they can be compared by eye. */
export const errorScale: Scale = {
  title: 'Mean error of the force between nodes', unit: 'fraction', low: 0.001, high: 1, log: true,
  note: 'Logarithmic; errors beyond its ends have their colours. Red ring: the predictor warns of a force there. Dark: fixed.',
};

export class Discs {
  readonly group = new Group();
  private readonly discs: InstancedMesh;
  private readonly rings: InstancedMesh;
  private readonly places: readonly Matrix4[];

  constructor({ points_m }: BodyData, { rows, weights }: BetweenNodes) {
    const n = rows.length / 3, radius = Math.min(0.03, 0.5 / Math.sqrt(n)) * boundsOf(points_m).radius;
    this.places = Array.from({ length: n }, (_, i) => {
      const [a, b, c] = [0, 1, 2].map((k) => row(points_m, rows[3 * i + k]!)) as [V3, V3, V3];
      const normal = unit(cross(sub(b, a), sub(c, a))), turn = new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), new Vector3(...normal));
      // Above the surface, which is not flat, and each at a height of its own where they overlap.
      const at = [a, b, c].reduce((sum, corner, k) => add(sum, scale(weights[3 * i + k]!, corner)), scale((0.15 + (0.15 * i) / n) * radius, normal));
      return new Matrix4().compose(new Vector3(...at), turn, new Vector3(radius, radius, radius));
    });
    this.discs = new InstancedMesh(new CircleGeometry(1, 24), new MeshBasicMaterial(), n);
    this.rings = new InstancedMesh(new RingGeometry(1, 1.4, 24), new MeshBasicMaterial({ color: 0xe01040 }), n);
    this.discs.frustumCulled = this.rings.frustumCulled = false;
    this.group.add(this.discs, this.rings);
  }
  show(errors: PointErrors, on: Scale): void {
    const none = new Matrix4().makeScale(0, 0, 0);
    this.places.forEach((place, i) => {
      this.discs.setMatrixAt(i, place);
      this.discs.setColorAt(i, new Color(...linearColour(placeOn(on, errors.force_error[i]!))));
      this.rings.setMatrixAt(i, errors.flagged[i]! > 0 ? place : none);
    });
    this.discs.instanceMatrix.needsUpdate = this.rings.instanceMatrix.needsUpdate = this.discs.instanceColor!.needsUpdate = true;
  }
}
