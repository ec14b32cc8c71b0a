// The module: text in, text out. It imports nothing, so this file serves page and node alike.
const [encoder, decoder] = [new TextEncoder(), new TextDecoder()];

export class Loop {
  static async load(bytes) {
    const { module, instance } = await WebAssembly.instantiate(bytes, {});
    return new Loop(module, instance.exports);
  }

  constructor(module, exports) {
    Object.assign(this, { module, exports, texture: null });
  }

  // One more, with memory of its own, which goes when it does.
  async twin() {
    const twin = new Loop(this.module, (await WebAssembly.instantiate(this.module, {})).exports);
    if (this.texture) twin.model(this.texture);
    return twin;
  }

  // Bytes into the module's buffer. Making room may grow its memory, so memory is looked at afterwards.
  put(bytes) {
    const at = this.exports.palpate_room(bytes.length);
    new Uint8Array(this.exports.memory.buffer, at, bytes.length).set(bytes);
  }

  // Asks, and returns what `ok` has; what went wrong is thrown as the sentence that it is.
  ask(request) {
    this.put(encoder.encode(JSON.stringify(request)));
    const length = this.exports.palpate_call();
    const bytes = new Uint8Array(this.exports.memory.buffer, this.exports.palpate_text(), length);
    const answer = JSON.parse(decoder.decode(bytes));
    if ("error" in answer) throw new Error(answer.error);
    return answer.ok;
  }

  // Hands over the texture model, which is no part of the module.
  model(bytes) {
    this.texture = bytes;
    this.put(bytes);
    this.exports.palpate_model();
  }
}
