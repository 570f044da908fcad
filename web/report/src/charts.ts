// Charts in which one can zoom by dragging; a double click shows the whole again.
import uPlot from 'uplot';
import { joined } from '../../view/src/plot.js';
import type { Chart } from './data.js';

const colours = ['--model', '--linear', '--ink', '--c3', '--c4', '--c5', '--c6', '--c7'];

function made(element: HTMLElement, chart: Chart): uPlot {
  const style = getComputedStyle(document.documentElement), colour = (name: string) => style.getPropertyValue(name).trim();
  const font = '12px system-ui, sans-serif';
  const axis = (label: string, log: boolean, size: number): uPlot.Axis => ({
    label, size, labelSize: 18, font, labelFont: font, stroke: colour('--ink'), grid: { stroke: colour('--line'), width: 1 },
    ticks: { stroke: colour('--line'), width: 1, size: 4 },
    // Of a logarithmic axis only the powers of ten are labelled.
    values: (_, ticks) => ticks.map((x) => (log && !Number.isInteger(Number(Math.log10(x).toFixed(6))) ? '' : `${Number(x.toPrecision(6))}`)),
  });
  const series = chart.curves.map(({ title, mark, color }): uPlot.Series => {
    const stroke = colour(colours[color] ?? '--ink'), dots = mark === 'points' || mark === 'joined';
    return {
      label: title, stroke, width: 2, spanGaps: true,
      ...(mark === 'dashes' ? { dash: [7, 5] } : mark === 'dotted' ? { dash: [2, 4] } : {}),
      ...(mark === 'points' ? { paths: () => null } : {}),
      points: { show: dots, size: 7, fill: stroke, stroke },
      value: (_, y) => (y === null || y === undefined ? '' : `${Number(y.toPrecision(4))}`),
    };
  });
  const data = joined(chart.curves);
  return new uPlot({
    title: chart.title,
    width: Math.max(240, element.clientWidth),
    height: 280,
    pxAlign: 0,
    scales: {
      x: { time: false, distr: chart.log_x ? 3 : 1 },
      y: { distr: chart.log_y ? 3 : 1, ...(chart.range ? { range: [chart.range[0], chart.range[1]] as [number, number] } : chart.log_y ? {} : { range: (_: uPlot, low: number, high: number): [number, number] => [Math.min(0, low), high > 0 ? 1.05 * high : 1] }) },
    },
    axes: [axis(chart.x, chart.log_x ?? false, 34), axis(chart.y, chart.log_y ?? false, 52)],
    series: [{ label: chart.x, value: (_, x) => (x === null || x === undefined ? '' : `${Number(x.toPrecision(4))}`) }, ...series],
    cursor: { drag: { x: true, y: false } },
  }, data as uPlot.AlignedData, element);
}

/** Two samples at one abscissa make a step; uPlot needs ascending ones, so the second is moved by a billionth. */
function ascending(chart: Chart): Chart {
  return {
    ...chart,
    curves: chart.curves.map((curve) => {
      const x = [...curve.x];
      if (curve.mark !== 'points') for (let i = 1; i < x.length; ++i) if (x[i]! <= x[i - 1]!) x[i] = x[i - 1]! * (1 + 1e-9) + Number.MIN_VALUE;
      return { ...curve, x };
    }),
  };
}

export function drawChart(element: HTMLElement, given: Chart): void {
  const chart = ascending(given);
  element.setAttribute('role', 'img');
  element.setAttribute('aria-label', `${chart.title}: ${chart.y} against ${chart.x}; ${chart.curves.map(({ title }) => title).join(', ')}`);
  let plot = made(element, chart);
  new ResizeObserver(() => plot.setSize({ width: Math.max(240, element.clientWidth), height: 280 })).observe(element);
  const again = () => {
    plot.destroy();
    plot = made(element, chart);
  };
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', again);
  // Paper is white, and two charts stand side by side on it.
  addEventListener('beforeprint', again);
  addEventListener('afterprint', again);
}
