// The legend of a colour map: title, bar, ticks and unit.
import { cssOf, linearColour } from './colour_maps.js';
import { shown, significant, ticks } from './numbers.js';

export interface Scale {
  readonly title: string;
  /** SI unit of low and high; 'fraction' is shown in % */
  readonly unit: string;
  readonly low: number;
  readonly high: number;
  /** what bodies without a value look like, for example "grey: not trained" */
  readonly note?: string;
}

export class Legend {
  readonly element = document.createElement('figure');
  private readonly title = document.createElement('figcaption');
  private readonly bar = document.createElement('div');
  private readonly marks = document.createElement('div');
  private readonly note = document.createElement('div');
  private last = '';

  constructor() {
    this.element.className = 'legend';
    this.element.hidden = true;
    this.bar.className = 'legend-bar';
    const colours = Array.from({ length: 33 }, (_, i) => cssOf(linearColour(i / 32)));
    this.bar.style.background = `linear-gradient(to right, ${colours.join(', ')})`;
    this.marks.className = 'legend-marks';
    this.note.className = 'legend-note';
    this.element.append(this.title, this.bar, this.marks, this.note);
  }

  show(scale: Scale | null): void {
    const key = JSON.stringify(scale);
    if (key === this.last) return;
    this.last = key;
    this.element.hidden = scale === null;
    if (!scale) return;
    const { unit, factor } = shown(scale.unit, scale.high);
    this.title.textContent = `${scale.title} [${unit}]`;
    const low = scale.low * factor, high = scale.high * factor;
    this.marks.replaceChildren(...ticks(low, high, 4).map((value) => {
      const mark = document.createElement('span');
      mark.textContent = significant(value, 3).replace(/(\.\d*?)0+$/, '$1').replace(/\.$/, '');
      mark.style.left = `${high > low ? (100 * (value - low)) / (high - low) : 0}%`;
      return mark;
    }));
    this.note.textContent = scale.note ?? '';
    this.note.hidden = !scale.note;
  }
}
