// Presses every active node of a model by 1 mm along the inward normal and prints what a finger would feel.
// Usage: node palpate.mjs model.txt
import { readFile } from 'node:fs/promises';
import { modelFromText, PhynnessError } from 'phynness';

const [file] = process.argv.slice(2);
if (!file) {
  console.error('usage: node palpate.mjs model.txt');
  process.exit(2);
}
try {
  const model = await modelFromText(await readFile(file));
  const { outputNodes, fixedNodes, outputPoints, fixedPoints, triangles, activeNodes, title } = model.info;
  const nodes = [...outputNodes, ...fixedNodes], points = [...outputPoints, ...fixedPoints];
  const point = (i) => points.slice(3 * i, 3 * i + 3);
  const minus = (a, b) => a.map((x, k) => x - b[k]);
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

  const normal = new Map(nodes.map((node) => [node, [0, 0, 0]]));
  for (let t = 0; t < triangles.length; t += 3) {
    const corners = [...triangles.slice(t, t + 3)], [a, b, c] = corners.map(point);
    const area = cross(minus(b, a), minus(c, a));
    for (const i of corners) normal.get(nodes[i]).forEach((_, k, n) => (n[k] += area[k]));
  }
  console.log(`${title}\nnode  N per m`);
  for (const node of activeNodes) {
    const n = normal.get(node), size = Math.hypot(...n);
    if (size === 0) continue;
    const d = n.map((x) => (-0.001 * x) / size), { force } = model.force(node, d);
    console.log(`${node}  ${((force[0] * d[0] + force[1] * d[1] + force[2] * d[2]) / 1e-6).toFixed(2)}`);
  }
  model.dispose();
} catch (error) {
  console.error(error instanceof PhynnessError ? `error: ${file}: ${error.reason}` : `error: ${error.message}`);
  process.exit(1);
}
