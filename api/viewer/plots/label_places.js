// Where the labels of a picture stand: clear of its lines, of its marks and of each other.

/** What a line of text takes above and below its baseline, and beside it [units of the picture]. */
const [ABOVE, BELOW, BESIDE] = [11, 4, 2];
const FONT = "13px system-ui, sans-serif";
/** Steps along a line at which its label is tried [units of the picture]. */
const STEP = 4;

const pen = document.createElement("canvas").getContext("2d");

/** Width of words in the font of the picture. */
function widthOf(words, isBold) {
  pen.font = `${isBold ? "600 " : ""}${FONT}`;
  return pen.measureText(words).width;
}

/** Whether the line between two places runs through a box (Liang & Barsky, 1984). */
function runsThrough([[x0, y0], [x1, y1]], { left, right, top, bottom }) {
  let [enter, leave] = [0, 1];
  for (const [along, room] of [[x0 - x1, x0 - left], [x1 - x0, right - x0], [y0 - y1, y0 - top], [y1 - y0, bottom - y0]]) {
    if (along === 0 && room < 0) return false;
    if (along < 0) enter = Math.max(enter, room / along);
    if (along > 0) leave = Math.min(leave, room / along);
  }
  return enter <= leave;
}

const overlap = (a, b) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
const isWithin = (box, room) => box.left >= room.left && box.right <= room.right && box.top >= room.top && box.bottom <= room.bottom;

export class LabelPlaces {
  #room;
  #lines = [];
  #boxes = [];

  /** `room` {left, right, top, bottom} for labels. */
  constructor(room) {
    this.#room = room;
  }

  /** Keeps a line through places [x, y] free of labels. */
  keepLine(places) {
    places.slice(1).forEach((place, i) => this.#lines.push([places[i], place]));
  }

  /** Keeps a mark of a radius around a place free of labels. */
  keepMark([x, y], radius) {
    this.#boxes.push({ left: x - radius, right: x + radius, top: y - radius, bottom: y + radius });
  }

  /** The first of `places` {x, y, isEnd} for words that covers nothing, otherwise that which covers least; it is kept free from then on. */
  choose(words, places, isBold = false) {
    const width = widthOf(words, isBold);
    const boxes = places.map(({ x, y, isEnd }) => ({ left: (isEnd ? x - width : x) - BESIDE, right: (isEnd ? x : x + width) + BESIDE, top: y - ABOVE, bottom: y + BELOW }));
    const covered = boxes.map((box) => this.#coveredBy(box));
    const best = covered.indexOf(Math.min(...covered));
    this.#boxes.push(boxes[best]);
    return places[best];
  }

  /** How much a box covers; more than all there is where it has no room. */
  #coveredBy(box) {
    const [lines, boxes] = [this.#lines.filter((line) => runsThrough(line, box)), this.#boxes.filter((other) => overlap(box, other))];
    const most = this.#lines.length + this.#boxes.length + 1;
    return lines.length + boxes.length + (isWithin(box, this.#room) ? 0 : most);
  }

  /** The place for the label of a level line at a height: above or below it, at its left end or, with `isEnd`, its right one, then at the other, then between. */
  alongLine(words, y, isEnd = false) {
    const { left, right } = this.#room;
    const [from, to] = [left + BESIDE + 4, right - BESIDE - 4];
    const ends = [{ x: from }, { x: to, isEnd: true }];
    const inner = Array.from({ length: Math.max(0, Math.floor((to - widthOf(words) - from) / STEP)) }, (_, i) => ({ x: from + (i + 1) * STEP }));
    const order = [...(isEnd ? ends.toReversed() : ends), ...(isEnd ? inner.toReversed() : inner)];
    return this.choose(words, order.flatMap((place) => [{ ...place, y: y - BELOW - 1 }, { ...place, y: y + ABOVE + 3 }]));
  }

  /** The place for the label of a mark: to one of its sides, below or above, then farther away, which `isFar` says. */
  besideMark(words, [x, y]) {
    const rows = [18, -10, 34, -26, 50, -42];
    return this.choose(words, rows.flatMap((down, i) => [{ x: x + 10, isEnd: false }, { x: x - 10, isEnd: true }].map((side) => ({ ...side, y: y + down, isFar: i > 1 }))), true);
  }
}
