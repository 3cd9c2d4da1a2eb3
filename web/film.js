// Pictures over time (yarm.console.film): from this console, or out of an exported page. And what plays them.

import { decode } from "./wire.js";

const KEPT = 6; // blocks that stay unpacked
/** What messages are of, in the order in which a moment's are shown. */
export const KINDS = ["scene", "map", "marks", "health", "events", "state"];
const SHORTEST_MS = 40; // between two pictures that are shown

/** A film that is asked for block by block: "" for the console's own, "results/..." for a run's. */
export class RemoteFilm {
  constructor(base = "") {
    this.base = base;
  }

  async index() {
    return (await this.get("film")).json();
  }

  async block(number) {
    return (await this.get(`film/${number}`)).arrayBuffer();
  }

  async get(path) {
    const response = await fetch(`${this.base}/${path}`);
    if (!response.ok) throw new Error((await response.json()).message);
    return response;
  }
}

/** A film that came with the page; its blocks are texts in base64. */
export class StoredFilm {
  constructor(film) {
    this.film = film;
  }

  async index() {
    return this.film;
  }

  async block(number) {
    return Uint8Array.from(atob(this.film.data[number]), (letter) => letter.charCodeAt(0)).buffer;
  }
}

/** Entries of a block: time in s, header, arrays. */
export async function unpack(packed) {
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const view = new DataView(bytes.buffer);
  let at = 0;
  const count = () => view.getUint32((at += 4) - 4, true);
  const pieces = Array.from({ length: count() }, () => {
    const length = count();
    return bytes.subarray(at, (at += length));
  });
  return Array.from({ length: count() }, () => {
    const time_s = view.getFloat64(at, true);
    at += 8;
    const own = Array.from({ length: count() }, () => pieces[count()]);
    const message = new Uint8Array(own.reduce((sum, piece) => sum + piece.length, 0));
    own.reduce((to, piece) => (message.set(piece, to), to + piece.length), 0);
    return { time_s, ...decode(message.buffer) };
  });
}

/** Shows a film: a moment of it, or one after the other. */
export class Player {
  /** @param show what takes an entry; changed called when time or state of play is another; failed takes a text. */
  constructor(film, { show, changed, failed }) {
    this.film = film;
    this.show = show;
    this.changed = changed;
    this.failed = failed;
    this.index = { first: 0, blocks: [], events: [], notes: [], title: "" };
    this.unpacked = new Map();
    this.shown = new Map();
    this.at_s = 0;
    this.speed = 1;
    this.playing = false;
    this.wanted = null;
    this.busy = null;
    this.asked = 0; // moments that somebody asked for
  }

  async load() {
    this.index = await this.film.index();
    this.changed();
    return this.index;
  }

  get first_s() {
    return this.index.blocks.length ? this.index.blocks[0].first_s : 0;
  }

  get last_s() {
    return this.index.blocks.length ? this.index.blocks[this.index.blocks.length - 1].last_s : 0;
  }

  /** Show the moment; of several that are asked for meanwhile only the last. */
  seek(time_s) {
    this.asked += 1;
    return this.go(time_s);
  }

  go(time_s) {
    this.wanted = Math.min(this.last_s, Math.max(this.first_s, time_s));
    this.at_s = this.wanted;
    this.changed();
    if (!this.busy) this.busy = this.work().finally(() => (this.busy = null));
    return this.busy;
  }

  async work() {
    try {
      while (this.wanted !== null) {
        const time_s = this.wanted;
        this.wanted = null;
        await this.moment(time_s);
      }
    } catch (error) {
      this.pause();
      this.failed(`this moment cannot be shown: ${error.message}`);
    }
  }

  async moment(time_s) {
    const { blocks, first } = this.index;
    if (!blocks.length) return;
    let i = blocks.findIndex((block) => block.last_s >= time_s);
    if (i < 0) i = blocks.length - 1;
    if (i > 0 && blocks[i].first_s > time_s) i -= 1;
    const entries = await this.entries(first + i, blocks[i].pictures);
    const newest = new Map();
    for (const entry of entries) {
      if (entry.time_s <= time_s + 1e-6 || !newest.has("state")) newest.set(entry.header.kind, entry);
    }
    for (const kind of KINDS) {
      const entry = newest.get(kind);
      if (entry && (kind === "state" || this.shown.get(kind) !== entry)) {
        this.shown.set(kind, entry);
        this.show(entry);
      }
    }
  }

  async entries(number, pictures) {
    const known = this.unpacked.get(number);
    this.unpacked.delete(number);
    const found = known && known.pictures === pictures ? known : { pictures, entries: await unpack(await this.film.block(number)) };
    this.unpacked.set(number, found);
    if (this.unpacked.size > KEPT) this.unpacked.delete(this.unpacked.keys().next().value);
    return found.entries;
  }

  /** One picture on, or back; a moment that is asked for before the pictures have come goes before. */
  async step(way) {
    this.pause();
    const asked = this.asked;
    const { blocks, first } = this.index;
    const times = [];
    for (let i = 0; i < blocks.length; i++) {
      if (blocks[i].last_s < this.at_s - 30 || blocks[i].first_s > this.at_s + 30) continue;
      const own = await this.entries(first + i, blocks[i].pictures);
      times.push(...own.filter((entry) => entry.header.kind === "state").map((entry) => entry.time_s));
    }
    const next = way > 0 ? times.find((time) => time > this.at_s + 1e-3) : times.reverse().find((time) => time < this.at_s - 1e-3);
    if (next !== undefined && asked === this.asked) await this.go(next);
  }

  play() {
    if (this.playing) return;
    if (this.at_s >= this.last_s) this.at_s = this.first_s;
    this.playing = true;
    let before = performance.now();
    const turn = (now) => {
      if (!this.playing) return;
      if (now - before >= SHORTEST_MS && !this.busy) {
        const to_s = this.at_s + (this.speed * (now - before)) / 1000;
        before = now;
        if (to_s >= this.last_s) this.pause();
        this.seek(to_s);
      }
      requestAnimationFrame(turn);
    };
    requestAnimationFrame(turn);
    this.changed();
  }

  pause() {
    this.playing = false;
    this.changed();
  }
}
