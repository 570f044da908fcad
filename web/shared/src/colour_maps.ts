// A colour map that is perceptually even and readable by the colour-blind, computed for this program. Its colours lie on a
// curve from dark blue through green to yellow in Oklab (B. Ottosson, "A perceptual color space for image processing",
// 2020), at equal distances along this curve; lightness rises all the way, so that it also reads in grey.

export type Rgb = readonly [number, number, number];

/** sRGB, 0 ... 255, at equal distances. Between them colours are linear, at most 1.4 of 255 from the curve. */
const stops: readonly Rgb[] = [
  [31, 24, 93], [38, 55, 119], [44, 86, 136], [56, 116, 143], [79, 144, 142], [113, 171, 134], [154, 195, 120], [202, 216, 102], [255, 235, 80],
];

/** Of linear light to sRGB, 0 ... 1, and back. */
export const encoded = (x: number): number => (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
const decoded = (x: number): number => (x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4);

const steps = 256;
/** `steps` colours in linear light. */
const table: readonly Rgb[] = Array.from({ length: steps }, (_, i) => {
  const at = (i / (steps - 1)) * (stops.length - 1), k = Math.min(stops.length - 2, Math.floor(at));
  const part = (c: 0 | 1 | 2) => decoded((stops[k]![c] + (at - k) * (stops[k + 1]![c] - stops[k]![c])) / 255);
  return [part(0), part(1), part(2)];
});

/** The colour of 0 ... 1 in linear light; values beyond have the colours of the ends. */
export function linearColour(t: number): Rgb {
  const k = Math.round(Math.min(1, Math.max(0, t)) * (steps - 1));
  return table[Number.isNaN(k) ? 0 : k]!;
}

/** A colour in linear light as a CSS colour. */
export function cssOf(colour: Rgb): string {
  return `rgb(${colour.map((x) => Math.round(255 * encoded(x))).join(' ')})`;
}

/** Colours of vertices in linear light, n x 3. @param weights  0 ... 1: how far a value is known; 0 has colour `unknown` */
export function coloursOf(values: ArrayLike<number>, weights: ArrayLike<number>, low: number, high: number, unknown: Rgb,
  out: Float32Array): Float32Array {
  const span = high > low ? high - low : 1;
  for (let i = 0; i < values.length; ++i) {
    const w = Math.min(1, Math.max(0, weights[i]!)), colour = linearColour((values[i]! - low) / span);
    for (let k = 0; k < 3; ++k) out[3 * i + k] = w * colour[k]! + (1 - w) * unknown[k]!;
  }
  return out;
}
