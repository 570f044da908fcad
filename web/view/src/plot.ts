// The plot of force against depth in one direction: the model, stored finite element increments, and now.
import uPlot from 'uplot';

export interface PlotData {
  /** of the model: depth [m], force [N] */
  readonly curve: { depths: readonly number[]; forces: readonly number[] };
  /** finite elements in the same direction; null: none are stored */
  readonly stored: { depths: readonly number[]; forces: readonly number[] } | null;
  readonly now: { depth: number; force: number };
}

/** Rows of several curves over their common abscissas; null where a curve has no value. */
export function joined(curves: readonly { x: readonly number[]; y: readonly number[] }[]): (number | null)[][] {
  const x = [...new Set(curves.flatMap((curve) => [...curve.x]))].sort((a, b) => a - b);
  const index = new Map(x.map((value, i) => [value, i]));
  return [x, ...curves.map((curve) => {
    const y: (number | null)[] = new Array<number | null>(x.length).fill(null);
    curve.x.forEach((value, i) => (y[index.get(value)!] = curve.y[i]!));
    return y;
  })];
}

const millimetres = (depths: readonly number[]) => depths.map((depth) => depth * 1e3);

export class DepthPlot {
  private plot: uPlot | null = null;
  private last: PlotData | null = null;

  constructor(private readonly element: HTMLElement) {
    new ResizeObserver(() => this.plot?.setSize(this.size())).observe(element);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
      this.clear();
      this.show(this.last);
    });
  }

  /** @param data  null: nothing is drawn */
  show(data: PlotData | null): void {
    this.last = data;
    if (!data) return this.clear();
    this.plot ??= this.made();
    this.plot.setData(joined([
      { x: millimetres(data.curve.depths), y: data.curve.forces },
      { x: millimetres(data.stored?.depths ?? []), y: data.stored?.forces ?? [] },
      { x: [data.now.depth * 1e3], y: [data.now.force] },
    ]) as uPlot.AlignedData);
  }

  private size(): { width: number; height: number } {
    return { width: Math.max(120, this.element.clientWidth), height: Math.max(120, this.element.clientHeight) };
  }
  private clear(): void {
    this.plot?.destroy();
    this.plot = null;
  }
  private made(): uPlot {
    const style = getComputedStyle(this.element), colour = (name: string) => style.getPropertyValue(name).trim();
    const axis = (label: string): uPlot.Axis => ({
      label, stroke: colour('--quiet'), font: '12px system-ui, sans-serif', labelFont: '12px system-ui, sans-serif',
      labelSize: 18, grid: { stroke: colour('--line'), width: 1 }, ticks: { stroke: colour('--line'), width: 1, size: 4 },
    });
    const dots = (name: string, size: number): uPlot.Series => ({
      stroke: colour(name), paths: () => null, points: { show: true, size, fill: colour(name), stroke: colour(name) },
    });
    const range = (_: uPlot, low: number | null, high: number | null): uPlot.Range.MinMax =>
      [Math.min(0, low ?? 0), high !== null && high > 0 ? 1.05 * high : 1];
    return new uPlot({
      ...this.size(),
      pxAlign: 0,
      legend: { show: false },
      cursor: { show: false },
      padding: [8, 12, 0, 0],
      scales: { x: { time: false, range }, y: { range } },
      axes: [{ ...axis('depth [mm]'), size: 30 }, { ...axis('force [N]'), size: 44 }],
      series: [
        {},
        { stroke: colour('--curve'), width: 2, spanGaps: true, points: { show: false } },
        dots('--stored', 8),
        dots('--now', 11),
      ],
    }, [[], [], [], []], this.element);
  }
}
