// What a view is, and the tabs that choose one.
//
// The contract: a view is a class in a file of its own, made once with the store's `set` and listed in main.ts, in the order of the tabs. It
// makes its own `element`, which fills the stage: let it not scroll at 1280 × 720, and be of use 400 pixels wide. `draw(state)` is called for
// each change of the state while the view is visible, never twice in a frame, and with a file open (`state.first`); it must be quick while
// `state.moving`, and need draw nothing but a cursor where a state `showsTheSame`. A view keeps no state that others could want: it calls
// `set({ pointedAt })` for the direction under the pointer, `set({ incident, moving })` for drags, and the page draws the read-out and the
// dome. Values are asked of the core (core.ts), colours and legends are those of scale.ts and legend.ts, looks are in a style sheet: no inline
// markup or style attributes, which the content security policy refuses (setting `element.style.…` is fine).

import type { Change, State } from "./state";

export interface View {
  /** On the tab. */
  readonly name: string;
  readonly element: HTMLElement;
  draw(state: State): void;
}

export type Set = (change: Change) => void;

/** One button for each view; arrow keys move between them, and digits choose from anywhere on the page. */
export class Tabs {
  private readonly buttons: HTMLButtonElement[];
  private chosen = 0;

  constructor(
    private readonly views: readonly View[],
    list: HTMLElement,
    stage: HTMLElement,
    private readonly redraw: () => void,
  ) {
    this.buttons = views.map((view, k) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = view.name;
      button.id = `tab-${k}`;
      button.title = `key ${k + 1}`;
      button.setAttribute("role", "tab");
      button.addEventListener("click", () => this.choose(k));
      view.element.setAttribute("role", "tabpanel");
      view.element.setAttribute("aria-labelledby", button.id);
      view.element.classList.add("view");
      return button;
    });
    list.append(...this.buttons);
    stage.append(...views.map(({ element }) => element));
    list.addEventListener("keydown", (event) => this.step(event));
    this.mark();
  }

  get visible(): View {
    return this.views[this.chosen]!;
  }

  choose(k: number): void {
    if (k < 0 || k >= this.views.length) return;
    this.chosen = k;
    this.mark();
    this.redraw();
  }

  private step(event: KeyboardEvent): void {
    const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!by) return;
    event.preventDefault();
    this.choose((this.chosen + by + this.views.length) % this.views.length);
    this.buttons[this.chosen]!.focus();
  }

  private mark(): void {
    this.views.forEach(({ element }, k) => {
      element.hidden = k !== this.chosen;
      this.buttons[k]!.setAttribute("aria-selected", String(k === this.chosen));
      this.buttons[k]!.tabIndex = k === this.chosen ? 0 : -1;
    });
  }
}
