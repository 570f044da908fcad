// Recording and replaying of motions.
import { fileName, significant } from '../../shared/src/numbers.js';
import { norm, type V3 } from '../../shared/src/vectors.js';
import { byId, download, setText } from './dom.js';
import { largestDifference, motionOf, Recorder, stepAt, textOf, type Motion, type Step } from './motion.js';
import { placeAt } from './places.js';
import type { Session } from './session.js';
import type { HeldTool } from './state.js';
import type { View } from './view.js';

/** The forces of every step of a motion. @throws Error if a tool cannot be held in this model */
export function evaluated(session: Session, motion: Motion): Step[] {
  const refused = motion.tools.find((place) => !session.canHold(place));
  if (refused) throw new Error(`nodes ${refused.nodes.join(', ')} cannot be held in this model`);
  session.runtime.answer([]);
  return motion.steps.map((step) => {
    const { tools, indices } = toolsOf(motion, step), answer = session.runtime.answer(tools);
    const forces: (V3 | null)[] = motion.tools.map(() => null);
    indices.forEach((tool, i) => (forces[tool] = answer.forces[i] ?? null));
    return { ...step, forces };
  });
}
function toolsOf(motion: Motion, step: Step): { tools: HeldTool[]; indices: number[] } {
  const tools: HeldTool[] = [], indices: number[] = [];
  motion.tools.forEach((place, i) => {
    const displacement = step.displacements[i];
    if (displacement) {
      tools.push({ place, displacement });
      indices.push(i);
    }
  });
  return { tools, indices };
}

export class Recording {
  private recorder: Recorder | null = null;
  private motion: Motion | null = null;
  private playing = 0;
  private readonly record = byId('record', HTMLButtonElement);
  private readonly replay = byId('replay', HTMLButtonElement);
  private readonly save = byId('save-motion', HTMLButtonElement);
  private readonly note = byId('record-note', HTMLElement);

  constructor(private readonly view: View) {
    this.record.addEventListener('click', () => (this.recorder ? this.stop() : this.start()));
    this.replay.addEventListener('click', () => (this.playing ? this.halt('Stopped') : this.play()));
    this.save.addEventListener('click', () => {
      if (this.motion) download(textOf(this.motion), 'application/json', fileName(`${view.session.runtime.model.info.title} motion`, 'json'));
    });
    const file = byId('motion-file', HTMLInputElement);
    byId('open-motion', HTMLButtonElement).addEventListener('click', () => file.click());
    file.addEventListener('change', () => {
      const chosen = file.files?.[0];
      if (chosen) void chosen.text().then((text) => this.open(text));
      file.value = '';
    });
    view.onStep = () => this.step();
  }

  private start(): void {
    this.view.setMode('hold');
    this.recorder = new Recorder();
    this.step();
    setText(this.note, 'Recording');
    this.show();
  }
  private step(): void {
    const { session } = this.view, { tools, mode } = session.state;
    if (!this.recorder || mode !== 'hold' || session.problem !== null) return;
    const held = tools.map(({ place, displacement }, i) => ({ place, displacement, force: session.answer.forces[i]! }));
    if (held.length > 0 || this.recorder.length > 0)
      if (!this.recorder.add(performance.now() / 1e3, held)) this.stop(' The recording is full.');
  }
  private stop(why = ''): void {
    const motion = this.recorder?.motion(this.view.session.runtime.model.info.meshHash) ?? null;
    this.recorder = null;
    if (motion) this.motion = motion;
    setText(this.note, motion ? `${motion.steps.length} steps, ${significant(motion.steps.at(-1)!.time, 3)} s.${why}` : 'Nothing was held.');
    this.show();
  }

  /** Takes the text of a motion. */
  open(text: string): void {
    try {
      const motion = motionOf(text), mesh = this.view.session.runtime.model.info.meshHash;
      if (motion.meshHash !== null && motion.meshHash !== mesh) throw new Error('it was recorded on another mesh');
      if (motion.steps.some((step) => step.displacements.filter((d) => d !== null).length > 2))
        throw new Error('this page holds two tools at most');
      evaluated(this.view.session, motion);
      this.motion = motion;
      setText(this.note, `${motion.steps.length} steps, ${significant(motion.steps.at(-1)!.time, 3)} s`);
    } catch (error) {
      setText(this.note, `This motion is refused: ${(error as Error).message}.`);
    }
    this.view.changed(true);
    this.show();
  }

  private play(): void {
    const { motion, view } = this;
    if (!motion) return;
    let answers: Step[];
    try {
      answers = evaluated(view.session, motion);
    } catch (error) {
      return this.halt(`This motion is refused: ${(error as Error).message}.`);
    }
    view.setMode('hold');
    const known = motion.steps.some((step) => step.forces.some((force) => force !== null));
    const difference = largestDifference(motion.steps, answers);
    const largest = Math.max(0, ...answers.flatMap((step) => step.forces.map((force) => (force ? norm(force) : 0))));
    const verdict = known ? `Largest difference from the recorded forces: ${significant(difference, 2)} N of ${significant(largest, 3)} N.` : '';
    const begin = performance.now(), first = motion.steps[0]!.time;
    let next = 0;
    const frame = () => {
      const time = first + (performance.now() - begin) / 1e3, at = stepAt(motion.steps, time);
      // Through all steps since the last picture: work belongs to the path.
      for (; next <= at; ++next) view.session.setTools(toolsOf(motion, motion.steps[next]!).tools);
      view.changed(true);
      if (at === motion.steps.length - 1) this.halt(`Replayed ${motion.steps.length} steps. ${verdict}`);
      else this.playing = requestAnimationFrame(frame);
    };
    this.playing = requestAnimationFrame(frame);
    setText(this.note, 'Replaying');
    this.show();
  }
  private halt(note: string): void {
    cancelAnimationFrame(this.playing);
    this.playing = 0;
    setText(this.note, note);
    this.show();
  }
  /** For another model. */
  forget(): void {
    this.recorder = this.motion = null;
    this.halt('');
  }
  private show(): void {
    this.record.setAttribute('aria-pressed', String(this.recorder !== null));
    setText(this.record, this.recorder ? 'Stop recording' : 'Record a motion');
    setText(this.replay, this.playing ? 'Stop' : 'Replay');
    this.replay.disabled = this.motion === null || this.recorder !== null;
    this.save.disabled = this.motion === null || this.recorder !== null;
  }
}

/** A tool at a node, for scripts. */
export const heldAt = (node: number, displacement: V3): HeldTool => ({ place: placeAt(node), displacement });
