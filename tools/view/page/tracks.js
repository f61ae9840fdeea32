// The tree of tracks: what is shown, what is beside it, names, files; and the events of the track.
import { element } from "scree/text";

const kMostEvents = 300;

function make(name, properties = {}, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}

const kTexts = {
  sleep: ({ body, count }) => (count > 1 ? `${count} bodies fall asleep` : `body ${body} falls asleep`),
  wake: ({ body, count }) => (count > 1 ? `${count} bodies wake` : `body ${body} wakes`),
  hit: ({ body, count, value }) => `${count > 1 ? `${count} hits, the fastest` : "a hit"} of body ${body} at ${value.toPrecision(3)} m/s`,
  break: ({ body, count }) => (count > 1 ? `${count} joints break` : `joint ${body} breaks`),
  restore: ({ body, count }) => (count > 1 ? `${count} bodies are put back, because their states were not finite` : `body ${body} is put back, because its state was not finite`),
};

export class TrackList {
  constructor(page, model) {
    this.page = page;
    this.model = model;
    element("branch").addEventListener("click", () => this.branch());
    element("nudge").addEventListener("click", () => this.nudge());
    element("beside").addEventListener("change", (event) => this.setSecond(Number(event.target.value)));
    element("track-name").addEventListener("change", (event) => {
      const name = event.target.value.trim();
      if (name === "") event.target.value = this.model.tracks[this.model.track].name;
      else this.page.live.ask({ ask: "name", track: this.model.track, name });
    });
  }

  branch() {
    this.page.live.ask({ ask: "branch", track: this.page.trackHere(), step: this.page.stepNumber });
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
    this.page.live.fillSettings();
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
    const focused = [...element("tracks").querySelectorAll("button, a")].indexOf(document.activeElement);
    element("tracks").replaceChildren(...this.order.map((track) => {
      const { name, first, parent, error, live } = tracks[track];
      const choose = make("button", { type: "button", textContent: name, onclick: () => this.choose(track) });
      choose.setAttribute("aria-pressed", String(track === here));
      const text = [parent === null ? (live ? "scene" : "recording") : `from step ${first}`, error].filter(Boolean).join(": ");
      const item = make("li", {}, choose, make("span", { className: "note", textContent: ` ${text} ` }),
        make("a", { href: `/recording/${track}`, textContent: "recording", ariaLabel: `Save the recording of ${name}`, download: "" }), " ",
        make("a", { href: "#", textContent: "page", ariaLabel: `Save a page of ${name}`, onclick: (event) => this.savePage(event, track) }));
      item.style.marginLeft = `${this.depth(track)}em`;
      return item;
    }));
    // The element that had the focus keeps it, and a list that is open stays so.
    if (focused >= 0) element("tracks").querySelectorAll("button, a")[focused]?.focus();
    const others = this.order.filter((track) => track !== here);
    const listed = JSON.stringify(others.map((track) => [track, tracks[track].name]));
    if (this.others !== listed) {
      this.others = listed;
      element("beside").replaceChildren(make("option", { value: "-1", textContent: "nothing" }),
        ...others.map((track) => make("option", { value: String(track), textContent: tracks[track].name })));
    }
    element("beside").value = String(second);
    if (document.activeElement !== element("track-name")) element("track-name").value = tracks[here].name;
  }

  // Of the steps that the fields say, or of all.
  async savePage(event, track) {
    event.preventDefault();
    const { first, last, name } = this.model.tracks[track];
    const [from, to, every] = ["page-from", "page-to", "page-every"].map((id) => element(id).value);
    this.page.say("The page is being made.", true);
    try {
      const answer = await fetch(`/page/${track}?from=${from || first}&to=${to || last}&every=${every || 1}`);
      if (!answer.ok) throw new Error(await answer.text());
      const address = URL.createObjectURL(await answer.blob());
      make("a", { href: address, download: `${name}.html` }).click();
      setTimeout(() => URL.revokeObjectURL(address), 60000);
      this.page.say("The page is saved.");
    } catch (error) {
      this.page.say(`The page cannot be saved: ${error.message}`);
    }
  }

  // Those to be listed: hits below the least speed are left out.
  get events() {
    const least = Number(element("least-hit").value) || 0;
    const all = this.model.happened;
    if (this.filtered?.all !== all || this.filtered.least !== least) {
      this.filtered = { all, least, list: all.filter(({ kind, value }) => kind !== "hit" || value >= least) };
    }
    return this.filtered.list;
  }

  showEvents() {
    const { events } = this;
    const count = events.length > kMostEvents ? `the first ${kMostEvents} of ${events.length}` : String(events.length);
    if (element("events-count").textContent !== count) element("events-count").textContent = count;
    if (!element("events-box").open || this.listed === events) return;
    // Those that are listed already stay: one of them may have the focus.
    const items = element("events").children;
    const isLonger = this.listed && this.listed.length <= events.length && this.listedTrack === this.model.track &&
      this.listed.slice(0, kMostEvents).every((event, i) => event === events[i]);
    if (!isLonger) element("events").replaceChildren();
    this.listed = events;
    this.listedTrack = this.model.track;
    element("events").append(...events.slice(items.length, kMostEvents).map((event) => make("li", {},
      make("button", { type: "button", textContent: `step ${event.step}`, onclick: () => this.page.goToStep(event.step) }),
      ` ${kTexts[event.kind](event)}`)));
  }

  // To the event before or after a step.
  jump(by) {
    const steps = this.events.map(({ step }) => step);
    const step = this.page.stepNumber;
    const next = by > 0 ? steps.find((each) => each > step) : steps.filter((each) => each < step).pop();
    if (next !== undefined) this.page.goToStep(next);
  }
}
