// The layers of a body, and where values at nodes are of one layer.

/**
 * What is averaged at nodes belongs to one layer only where all elements around the node do. In an element at an interface it is
 * interpolated between such nodes and those of the interface, so it is a mean of both layers: a curve of its own.
 */
export class Layers {
  /** The curves {label, part, isMixed}; `part` is an index into the body's parts. */
  curves;
  #ofElement;

  constructor({ cells, partOf, parts }, field) {
    const shared = field.isMean ? nodesOfSeveral(cells, partOf) : new Set();
    const isMixed = (element) => cells.nodesOf(element).some((node) => shared.has(node));
    // Part by part, and what is inside one layer first.
    const keys = Array.from(partOf, (part, element) => 2 * part + (isMixed(element) ? 1 : 0));
    const order = [...new Set(keys)].sort((a, b) => a - b);
    this.#ofElement = keys.map((key) => order.indexOf(key));
    this.curves = order.map((key) => {
      const [part, mixed] = [key >> 1, key % 2 === 1];
      const name = parts.length > 1 ? parts[part] : field.label.split(" (")[0];
      return { label: mixed ? `${name}, with its neighbour` : name, part, isMixed: mixed };
    });
  }

  /** Index of the curve that an element belongs to. */
  curveOf(element) {
    return this.#ofElement[element];
  }
}

/** The nodes that elements of more than one part share. */
function nodesOfSeveral(cells, partOf) {
  const first = new Map();
  const shared = new Set();
  partOf.forEach((part, element) => {
    for (const node of cells.nodesOf(element)) {
      if (!first.has(node)) first.set(node, part);
      else if (first.get(node) !== part) shared.add(node);
    }
  });
  return shared;
}
