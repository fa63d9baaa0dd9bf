// Files come in: by drop, by dialog, by whoever has bytes. Out: the state with one more open file; the first is shown, the second compared with it.

import { Opened, Refused } from "./core";
import { fromPolar, toPolar } from "./directions";
import type { Store } from "./state";

/** Bytes that take long enough to wonder. */
const LARGE = 5e6;

export class Loader {
  constructor(
    private readonly store: Store,
    private readonly message: HTMLElement,
  ) {}

  /** Opens the bytes of a file; whether they are a BSDF, else what is wrong with them is said in the message. `place` among the files that came
   * with it: 0 is shown, 1 is compared with it, others are listed. */
  async open(name: string, bytes: Uint8Array, place = 0): Promise<boolean> {
    this.say(`reading ${name}, ${(bytes.length / 1e6).toFixed(1)} MB …`);
    // So that it is seen, before the page stands still.
    if (bytes.length > LARGE) await new Promise((painted) => setTimeout(painted, 30));
    const begun = performance.now();
    try {
      const opened = await Opened.open(name, bytes);
      const known = this.store.state.files.find((file) => file.takeErrors(opened));
      if (known) {
        // To draw what is known now.
        this.store.set({});
        this.say(`${name}: standard errors of ${known.name}`);
        return true;
      }
      this.add(opened, place);
    } catch (error) {
      this.complain(error instanceof Refused ? `${name}: ${error.message}` : `${name} cannot be read: ${String(error)}`);
      return false;
    }
    this.say(`${name}, read in ${Math.round(performance.now() - begun)} ms`);
    return true;
  }

  say(text: string): void {
    this.message.className = "";
    this.message.textContent = text;
  }

  complain(text: string): void {
    this.message.className = "problem";
    this.message.textContent = text;
  }

  /** Listens to dialogs and to drops anywhere on the page. */
  listen(...dialogs: HTMLInputElement[]): void {
    for (const dialog of dialogs) {
      dialog.addEventListener("change", () => {
        void this.openAll(dialog.files ?? []);
        dialog.value = "";
      });
    }
    document.addEventListener("dragover", (event) => {
      event.preventDefault();
      document.body.classList.add("dragging");
    });
    document.addEventListener("dragleave", () => document.body.classList.remove("dragging"));
    document.addEventListener("drop", (event) => {
      event.preventDefault();
      document.body.classList.remove("dragging");
      void this.openAll(event.dataTransfer?.files ?? []);
    });
  }

  private async openAll(given: ArrayLike<File>): Promise<void> {
    for (const [place, file] of Array.from(given).entries()) {
      // What is wrong with one stays on the screen.
      if (!(await this.open(file.name, new Uint8Array(await file.arrayBuffer()), place))) return;
    }
  }

  /** A file of the same name is taken for a newer state of it. */
  private add(opened: Opened, place: number): void {
    const { files, first, compared, incident } = this.store.state;
    const all = [...files.filter(({ name }) => name !== opened.name), opened];
    const errors = files.find((file) => opened.takeErrors(file));
    if (place > 0 && errors !== first) {
      const newer = first?.name === opened.name ? { first: opened } : {};
      this.store.set({ files: all, held: null, ...newer, ...(place === 1 || compared?.name === opened.name ? { compared: opened } : {}) });
      return;
    }
    const components = opened.summary.bands.flatMap((band) => band.components);
    const { thetaDeg, phiDeg } = toPolar(incident);
    this.store.set({
      files: all,
      first: opened,
      compared: null,
      held: null,
      decades: decades(Math.max(...components.map(({ maximum }) => maximum))),
      natural: components.some(({ is_coloured }) => is_coloured),
      incident: fromPolar(thetaDeg, phiDeg, components[0]?.incident_front ?? true),
    });
  }
}

/** Enough to see a dim diffuser, of 0.01 sr⁻¹, beside the largest value. */
function decades(maximum: number): number {
  return Math.min(8, Math.max(4, 2 * Math.ceil(Math.log10(maximum / 0.01) / 2))) || 4;
}
