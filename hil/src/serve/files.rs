//! The page's files, built into the program: those of the playground that a page without the module needs, and its own.

/// A file by its path, with its type.
pub(super) struct PageFile {
    path: &'static str,
    pub(super) media_type: &'static str,
    text: &'static str,
}

const JAVASCRIPT: &str = "text/javascript; charset=utf-8";

macro_rules! script {
    ($name:literal) => {
        PageFile {
            path: concat!("/", $name),
            media_type: JAVASCRIPT,
            text: include_str!(concat!("../../page/", $name)),
        }
    };
}

const FILES: [PageFile; 9] = [
    PageFile {
        path: "/",
        media_type: "text/html; charset=utf-8",
        text: include_str!("../../page/index.html"),
    },
    PageFile {
        path: "/style.css",
        media_type: "text/css; charset=utf-8",
        text: include_str!("../../page/style.css"),
    },
    script!("draw.js"),
    script!("finger.js"),
    script!("live.js"),
    script!("link.js"),
    script!("pad.js"),
    script!("panels.js"),
    script!("plots.js"),
];

/// What the playground's page says that a page over a run says otherwise.
const OTHERWISE: [(&str, &str); 3] = [
    ("<body>", "<body class=\"live\">"),
    (
        "<title>Palpate: touch it</title>",
        "<title>Palpate: live</title>",
    ),
    ("import \"palpate/main.js\"", "import \"palpate/live.js\""),
];

/// The file at a path.
pub(super) fn file(path: &str) -> Option<&'static PageFile> {
    FILES.iter().find(|file| file.path == path)
}

impl PageFile {
    /// Its text for a page that was asked for by this host's name, which may open a socket there and nowhere else.
    pub(super) fn text(&self, host: &str) -> String {
        if self.path != "/" {
            return self.text.to_owned();
        }
        let sockets = format!("connect-src 'self' ws://{host}");
        let own = [("connect-src 'self'", sockets.as_str())];
        let changes = OTHERWISE.iter().copied().chain(own);
        changes.fold(self.text.to_owned(), |text, (what, instead)| {
            text.replacen(what, instead, 1)
        })
    }
}

#[cfg(test)]
#[path = "files_tests.rs"]
mod tests;
