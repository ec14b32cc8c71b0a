//! The encoder as an ONNX model, for ONNX Runtime and whatever else reads one.
//!
//! `raw` [window, N, features] counts -> less the first sample -> times 1 / range -> GRU layers -> `latent` [N, Z].
//! ONNX has its gates in the order z, r, h; `linear_before_reset = 1` is the form with two biases.

use palpate_records::mcap::proto::Message;

use palpate_files::{Tensor, TextureModel};

/// The operators used are those of this set or older ones that it kept.
const OPERATORS: u32 = 14;
/// The file format that came with them.
const FORMAT: u32 = 7;

/// The model file's bytes.
pub fn encoder(model: &TextureModel) -> Vec<u8> {
    let mut graph = Message::default();
    for (kind, inputs, output) in [
        ("Slice", &["raw", "zero", "one", "zero"][..], "first"),
        ("Sub", &["raw", "first"], "offset"),
        ("Mul", &["offset", "factor"], "x0"),
    ] {
        graph.inner(1, &operation(kind, inputs, &[output], &[]));
    }
    for (l, layer) in model.layers().iter().enumerate() {
        let name = |what: &str| format!("{what}{l}");
        let inputs = [name("x"), name("W"), name("R"), name("B")];
        let inputs = inputs.each_ref().map(String::as_str);
        let attributes = [
            ("hidden_size", layer.units() as u64),
            ("linear_before_reset", 1),
        ];
        // Y is [window, 1, N, units], Y_h its last step.
        let last = l + 1 == model.layers().len();
        let (sequence, state) = (name("y"), name("h"));
        let outputs = [if last { "" } else { &sequence }, &state];
        graph.inner(1, &operation("GRU", &inputs, &outputs, &attributes));
        let (from, axis, to) = if last {
            (state, "zero", "latent".to_owned())
        } else {
            (sequence, "one", format!("x{}", l + 1))
        };
        graph.inner(1, &operation("Squeeze", &[&from, axis], &[&to], &[]));
    }
    graph.text(2, "palpate texture encoder");
    graph.inner(5, &whole("zero", 0)).inner(5, &whole("one", 1));
    let factors: Vec<f32> = model.with(|m| m.factors().collect());
    graph.inner(5, &floats("factor", &[factors.len()], &factors));
    for (l, layer) in model.layers().iter().enumerate() {
        let (units, inputs) = (layer.units(), layer.inputs());
        let rows = |tensor: &Tensor| reordered(&tensor.values);
        let weights = [
            (
                format!("W{l}"),
                vec![1, 3 * units, inputs],
                rows(&layer.weight_ih),
            ),
            (
                format!("R{l}"),
                vec![1, 3 * units, units],
                rows(&layer.weight_hh),
            ),
            (
                format!("B{l}"),
                vec![1, 6 * units],
                [rows(&layer.bias_ih), rows(&layer.bias_hh)].concat(),
            ),
        ];
        for (name, shape, values) in &weights {
            graph.inner(5, &floats(name, shape, values));
        }
    }
    let raw = [Some(model.window()), None, Some(model.features())];
    graph.inner(11, &value("raw", &raw));
    graph.inner(12, &value("latent", &[None, Some(model.latents())]));

    let mut file = Message::default();
    file.uint(1, FORMAT)
        .text(2, "palpate")
        .text(3, env!("CARGO_PKG_VERSION"));
    file.inner(7, &graph);
    let mut operators = Message::default();
    operators.uint(2, OPERATORS);
    file.inner(8, &operators);
    for (key, text) in model.metadata() {
        let mut property = Message::default();
        property.text(1, key).text(2, text);
        file.inner(14, &property);
    }
    file.bytes().to_vec()
}

/// A tensor's rows from r, z, n to z, r, h.
fn reordered(values: &[f32]) -> Vec<f32> {
    let gate = values.len() / 3;
    let (r, rest) = values.split_at(gate);
    let (z, n) = rest.split_at(gate);
    [z, r, n].concat()
}

/// `NodeProto`.
fn operation(kind: &str, inputs: &[&str], outputs: &[&str], attributes: &[(&str, u64)]) -> Message {
    const INT: u32 = 2;
    let mut node = Message::default();
    // An empty name stands for an input or output left out; it has to be there all the same.
    let named = |node: &mut Message, field, name: &str| {
        node.part(field, name.as_bytes());
    };
    for input in inputs {
        named(&mut node, 1, input);
    }
    for output in outputs {
        named(&mut node, 2, output);
    }
    node.text(4, kind);
    for &(name, number) in attributes {
        let mut attribute = Message::default();
        attribute.text(1, name).uint(3, number).uint(20, INT);
        node.inner(5, &attribute);
    }
    node
}

/// `TensorProto` of 32-bit floats.
fn floats(name: &str, shape: &[usize], values: &[f32]) -> Message {
    const FLOAT: u32 = 1;
    let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
    tensor(name, FLOAT, shape, &bytes)
}

/// `TensorProto` of one 64-bit integer.
fn whole(name: &str, value: i64) -> Message {
    const INT64: u32 = 7;
    tensor(name, INT64, &[1], &value.to_le_bytes())
}

fn tensor(name: &str, kind: u32, shape: &[usize], bytes: &[u8]) -> Message {
    let mut tensor = Message::default();
    for &length in shape {
        tensor.uint(1, length as u64);
    }
    tensor.uint(2, kind).text(8, name).data(9, bytes);
    tensor
}

/// `ValueInfoProto` of 32-bit floats; an unknown length is `N`.
fn value(name: &str, shape: &[Option<usize>]) -> Message {
    const FLOAT: u32 = 1;
    let mut dimensions = Message::default();
    for length in shape {
        let mut dimension = Message::default();
        match length {
            Some(length) => dimension.uint(1, *length as u64),
            None => dimension.text(2, "N"),
        };
        dimensions.inner(1, &dimension);
    }
    let (mut tensor, mut kind, mut value) =
        (Message::default(), Message::default(), Message::default());
    tensor.uint(1, FLOAT).inner(2, &dimensions);
    kind.inner(1, &tensor);
    value.text(1, name).inner(2, &kind);
    value
}
