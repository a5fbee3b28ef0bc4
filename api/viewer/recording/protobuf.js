// Decodes protobuf messages by the descriptors that a recording carries. Libraries for this make code at run time, which the
// page's content security policy forbids.

// Types of fields, as in descriptor.proto.
const DOUBLE = 1, FLOAT = 2, INT64 = 3, UINT64 = 4, INT32 = 5, FIXED64 = 6, FIXED32 = 7, BOOL = 8, STRING = 9;
const MESSAGE = 11, BYTES = 12, UINT32 = 13, ENUM = 14, SFIXED32 = 15, SFIXED64 = 16, SINT32 = 17, SINT64 = 18;
const REPEATED = 3;
/** Bytes on the wire for each wire type that is not a message's own. */
const VARINT = 0, WIDE = 1, LENGTH = 2, NARROW = 5;

const field = (name, type, label = 1, type_name = "") => ({ name, type, label, type_name });

/** What descriptors themselves are made of; only the fields that are needed. */
const DESCRIPTORS = new Map([
  [".FileDescriptorSet", new Map([[1, field("file", MESSAGE, REPEATED, ".File")]])],
  [".File", new Map([[2, field("package", STRING)], [4, field("message_type", MESSAGE, REPEATED, ".Message")]])],
  [".Message", new Map([
    [1, field("name", STRING)],
    [2, field("field", MESSAGE, REPEATED, ".Field")],
    [3, field("nested_type", MESSAGE, REPEATED, ".Message")],
  ])],
  [".Field", new Map([
    [1, field("name", STRING)],
    [3, field("number", INT32)],
    [4, field("label", INT32)],
    [5, field("type", INT32)],
    [6, field("type_name", STRING)],
  ])],
]);

/** A decoder of the messages of type `name` from the bytes of a `FileDescriptorSet`. */
export function decoderOf(name, descriptorSet) {
  const types = new Map();
  const add = (prefix, message) => {
    const path = `${prefix}.${message.name}`;
    types.set(path, new Map(message.field.map((f) => [f.number, f])));
    message.nested_type.forEach((nested) => add(path, nested));
  };
  for (const file of decode(DESCRIPTORS, ".FileDescriptorSet", descriptorSet).file) {
    file.message_type.forEach((message) => add(file.package ? `.${file.package}` : "", message));
  }
  if (!types.has(`.${name}`)) throw new Error(`The recording does not describe ${name}.`);
  return (bytes) => decode(types, `.${name}`, bytes);
}

/** One message as a plain object; what is absent has its default (null for messages). `bytes` are views, not copies. */
function decode(types, type, bytes) {
  const fields = types.get(type);
  const wire = { bytes, view: new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength), at: 0 };
  const message = {};
  for (const f of fields.values()) message[f.name] = f.label === REPEATED ? [] : defaultOf(f.type);
  while (wire.at < bytes.length) {
    const tag = varint(wire);
    const known = fields.get(Math.floor(tag / 8));
    const wireType = tag % 8;
    if (!known) skip(wire, wireType);
    else if (known.label !== REPEATED) message[known.name] = value(types, known, wire);
    else if (wireType === LENGTH && isNumber(known.type)) {
      // Packed: numbers without tags.
      const end = varint(wire) + wire.at;
      while (wire.at < end) message[known.name].push(value(types, known, wire));
    } else message[known.name].push(value(types, known, wire));
  }
  return message;
}

const isNumber = (type) => type !== STRING && type !== BYTES && type !== MESSAGE;

function defaultOf(type) {
  if (type === STRING) return "";
  if (type === BYTES) return new Uint8Array(0);
  if (type === MESSAGE) return null;
  return type === BOOL ? false : 0;
}

function value(types, f, wire) {
  const at = wire.at;
  switch (f.type) {
    case DOUBLE: wire.at += 8; return wire.view.getFloat64(at, true);
    case FLOAT: wire.at += 4; return wire.view.getFloat32(at, true);
    case FIXED64: wire.at += 8; return Number(wire.view.getBigUint64(at, true));
    case SFIXED64: wire.at += 8; return Number(wire.view.getBigInt64(at, true));
    case FIXED32: wire.at += 4; return wire.view.getUint32(at, true);
    case SFIXED32: wire.at += 4; return wire.view.getInt32(at, true);
    case BOOL: return varint(wire) !== 0;
    case INT32: case ENUM: case INT64: return signed(wire);
    case UINT32: case UINT64: return varint(wire);
    case SINT32: case SINT64: { const n = varint(wire); return n % 2 ? -(n + 1) / 2 : n / 2; }
    case STRING: return new TextDecoder().decode(run(wire));
    case BYTES: return run(wire);
    case MESSAGE: return decode(types, f.type_name, run(wire));
    default: throw new Error(`Fields of type ${f.type} are not read.`);
  }
}

/** The next bytes with their length before them. */
function run(wire) {
  const length = varint(wire);
  wire.at += length;
  if (wire.at > wire.bytes.length) throw new Error("A message ends too early.");
  return wire.bytes.subarray(wire.at - length, wire.at);
}

/** Exact up to 2⁵³, which no count of a recording reaches. */
function varint(wire) {
  let result = 0;
  for (let scale = 1; wire.at < wire.bytes.length; scale *= 128) {
    const byte = wire.bytes[wire.at++];
    result += (byte & 127) * scale;
    if (byte < 128) return result;
  }
  throw new Error("A message ends too early.");
}

/** Negative numbers are ten bytes of two's complement. */
function signed(wire) {
  const at = wire.at;
  const plain = varint(wire);
  if (plain < 2 ** 53) return plain;
  let result = 0n;
  for (let i = at, shift = 0n; i < wire.at; i++, shift += 7n) result |= BigInt(wire.bytes[i] & 127) << shift;
  return Number(BigInt.asIntN(64, result));
}

function skip(wire, wireType) {
  if (wireType === VARINT) varint(wire);
  else if (wireType === WIDE) wire.at += 8;
  else if (wireType === LENGTH) run(wire);
  else if (wireType === NARROW) wire.at += 4;
  else throw new Error(`Wire type ${wireType} is not read.`);
}
