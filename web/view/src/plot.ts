// The plot of force against depth in one direction: the model, stored finite element increments, and now.
import { ticks } from '../../shared/src/numbers.js';

interface Curve {
  /** [m] */
  readonly depths: readonly number[];
  /** [N] */
  readonly forces: readonly number[];
}
export interface PlotData {
  readonly curve: Curve;
  /** finite elements in the same direction; null: none are stored */
  readonly stored: Curve | null;
  readonly now: { depth: number; force: number };
}

// Of the axes, in pixels.
const left = 52, right = 330, top = 8, bottom = 152;

/** As SVG. */
export function drawn({ curve, stored, now }: PlotData): string {
  const longest = 1e3 * Math.max(...curve.depths, ...(stored?.depths ?? []), now.depth) || 1;
  const largest = 1.05 * Math.max(...curve.forces, ...(stored?.forces ?? []), now.force) || 1;
  const x = (mm: number) => (left + ((right - left) * mm) / longest).toFixed(1);
  const y = (force: number) => (bottom - ((bottom - top) * force) / largest).toFixed(1);
  const dots = (kind: string, { depths, forces }: Curve) =>
    depths.map((depth, i) => `<circle class="${kind}" cx="${x(1e3 * depth)}" cy="${y(forces[i]!)}" r="${kind === 'now' ? 5 : 4}"/>`).join('');
  return `<svg viewBox="0 0 340 190"><g class="grid">
    ${ticks(0, longest).map((mm) => `<path d="M${x(mm)} ${top}V${bottom}"/><text x="${x(mm)}" y="${bottom + 14}" text-anchor="middle">${mm}</text>`).join('')}
    ${ticks(0, largest).map((force) => `<path d="M${left} ${y(force)}H${right}"/><text x="${left - 5}" y="${y(force)}" dy="4" text-anchor="end">${force}</text>`).join('')}
    <text x="${(left + right) / 2}" y="${bottom + 32}" text-anchor="middle">depth [mm]</text>
    <text transform="translate(12 ${(top + bottom) / 2}) rotate(-90)" text-anchor="middle">force [N]</text></g>
    <polyline points="${curve.depths.map((depth, i) => `${x(1e3 * depth)},${y(curve.forces[i]!)}`).join(' ')}"/>
    ${stored ? dots('stored', stored) : ''}${dots('now', { depths: [now.depth], forces: [now.force] })}</svg>`;
}
