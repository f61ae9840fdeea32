// The tree of tracks: what is shown, what is beside it, names, files; and the events of the track.

const kMostEvents = 300;
const element = (id) => document.getElementById(id);

function make(name, properties = {}, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}

const kWords = {
  sleep: ({ body, count }) => (count > 1 ? `${count} bodies fall asleep` : `body ${body} falls asleep`),
  wake: ({ body, count }) => (count > 1 ? `${count} bodies wake` : `body ${body} wakes`),
  hit: ({ body, count, value }) => `${count > 1 ? `${count} hits, the fastest` : "a hit"} of body ${body} at ${value.toPrecision(3)} m/s`,
  break: ({ body, count }) => (count > 1 ? `${count} joints break` : `joint ${body} breaks`),
  restore: ({ body, count }) => (count > 1 ? `${count} bodies are put back: not finite` : `body ${body} is put back: not finite`),
};

export class TrackList {
  constructor(page, model) {
    this.page = page;
    this.model = model;
    element("branch").addEventListener("click", () => this.branch());
    element("nudge").addEventListener("click", () => this.nudge());
    element("beside").addEventListener("change", (event) => this.setSecond(Number(event.target.value)));
    element("track-name").addEventListener("change", (event) => {
      this.model.ask({ ask: "name", track: this.model.track, name: event.target.value });
    });
    element("least-hit").addEventListener("change", () => { this.listed = undefined; });
  }

  branch() {
    this.model.ask({ ask: "branch", track: this.page.trackHere(), step: this.page.stepNumber });
  }

  // Another future, in which the chosen body is off by a unit in the last place.
  nudge() {
    const body = this.model.bodies[this.page.scene.chosen];
    if (!body) return this.page.say("Choose a body first: it is moved by one unit in the last place.");
    const beside = this.page.trackHere();
    this.afterBranch = () => this.setSecond(beside);
    this.page.touch.send({ kind: "nudge", body: body.index });
    return undefined;
  }

  setSecond(track) {
    this.model.second = track === this.model.track ? -1 : track;
    this.model.asked = "";
    this.show();
    this.page.drawn = undefined;
  }

  choose(track) {
    const step = this.page.stepNumber;
    this.model.track = track;
    if (this.model.second === track) this.model.second = -1;
    this.model.version += 1;
    this.model.asked = "";
    this.page.goToStep(Math.min(step, this.model.last));
    this.show();
    this.page.drawn = undefined;
  }

  // The server has made a branch for this page.
  enter(track) {
    const isPlaying = this.model.isPlaying;
    this.choose(track);
    this.afterBranch?.();
    this.afterBranch = undefined;
    if (isPlaying) this.page.play(true);
  }

  depth(track) {
    const { parent } = this.model.tracks[track];
    return parent === null ? 0 : 1 + this.depth(parent);
  }

  // Children behind their parents.
  get order() {
    const list = [];
    const add = (parent) => this.model.tracks.forEach(({ track, parent: above }) => {
      if (above !== parent) return;
      list.push(track);
      add(track);
    });
    add(null);
    return list;
  }

  show() {
    const { tracks, track: here, second } = this.model;
    element("tracks").replaceChildren(...this.order.map((track) => {
      const { name, first, parent, error, live } = tracks[track];
      const choose = make("button", { type: "button", textContent: name, onclick: () => this.choose(track) });
      choose.setAttribute("aria-pressed", String(track === here));
      const text = [parent === null ? (live ? "scene" : "recording") : `from step ${first}`, error].filter(Boolean).join(": ");
      const item = make("li", {}, choose, make("span", { className: "note", textContent: ` ${text} ` }),
        make("a", { href: `/recording/${track}`, textContent: "recording", download: "" }), " ",
        make("a", { href: "#", textContent: "page", onclick: (event) => this.savePage(event, track) }));
      item.style.marginLeft = `${this.depth(track)}em`;
      return item;
    }));
    element("beside").replaceChildren(make("option", { value: "-1", textContent: "nothing" }),
      ...this.order.filter((track) => track !== here).map((track) => make("option", { value: String(track), textContent: tracks[track].name })));
    element("beside").value = String(second);
    if (document.activeElement !== element("track-name")) element("track-name").value = tracks[here].name;
  }

  savePage(event, track) {
    event.preventDefault();
    const { first, last } = this.model.tracks[track];
    window.location.assign(`/page/${track}?from=${first}&to=${last}`);
  }

  // Those to be listed: hits below the least speed are left out.
  get events() {
    const least = Number(element("least-hit").value) || 0;
    return this.model.happened.filter(({ kind, value }) => kind !== "hit" || value >= least);
  }

  showEvents() {
    const state = `${this.model.track} ${this.model.happened.length} ${element("least-hit").value}`;
    if (this.listed === state || !element("events-box").open) return;
    this.listed = state;
    const all = this.events;
    element("events").replaceChildren(...all.slice(0, kMostEvents).map((event) => make("li", {},
      make("button", { type: "button", textContent: `step ${event.step}`, onclick: () => this.page.goToStep(event.step) }),
      ` ${kWords[event.kind](event)}`)));
    element("events-count").textContent = all.length > kMostEvents ? `the first ${kMostEvents} of ${all.length}` : String(all.length);
  }

  // To the event before or after a step.
  jump(by) {
    const steps = this.events.map(({ step }) => step);
    const step = this.page.stepNumber;
    const next = by > 0 ? steps.find((each) => each > step) : steps.filter((each) => each < step).pop();
    if (next !== undefined) this.page.goToStep(next);
  }
}
