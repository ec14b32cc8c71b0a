//! The page's files, built into the program: those of the playground that a page without the module needs, and its own.

/// A file by its path, with its type.
pub(super) struct PageFile {
    path: &'static str,
    pub(super) media_type: &'static str,
    text: &'static str,
}

const HTML: &str = "text/html; charset=utf-8";
const JAVASCRIPT: &str = "text/javascript; charset=utf-8";

macro_rules! script {
    ($name:literal) => {
        PageFile {
            path: concat!("/", $name),
            media_type: JAVASCRIPT,
            text: include_str!(concat!("../../../page/", $name)),
        }
    };
}

const FILES: [PageFile; 11] = [
    PageFile {
        path: "/",
        media_type: HTML,
        text: include_str!("../../../page/index.html"),
    },
    PageFile {
        path: "/style.css",
        media_type: "text/css; charset=utf-8",
        text: include_str!("../../../page/style.css"),
    },
    script!("draw.js"),
    script!("finger.js"),
    script!("limits.js"),
    script!("live.js"),
    script!("link.js"),
    script!("pad.js"),
    script!("panels.js"),
    script!("plots.js"),
    script!("recording.js"),
];

/// The page in a notebook, over a loop in Python; `FILES` has the scripts that it loads.
const NOTEBOOK: PageFile = script!("notebook.js");

/// The pages of a study: the participant's and the experimenter's.
const STUDY: [PageFile; 7] = [
    PageFile {
        path: "/",
        media_type: HTML,
        text: include_str!("../../../page/study/participant.html"),
    },
    PageFile {
        path: "/experimenter",
        media_type: HTML,
        text: include_str!("../../../page/study/experimenter.html"),
    },
    PageFile {
        path: "/study.css",
        media_type: "text/css; charset=utf-8",
        text: include_str!("../../../page/study/study.css"),
    },
    script!("study/participant.js"),
    script!("study/experimenter.js"),
    script!("study/desk.js"),
    PageFile {
        path: "/study/limits.js",
        media_type: JAVASCRIPT,
        text: include_str!("../../../page/limits.js"),
    },
];

/// Kind of session that a page shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Page {
    /// A run that goes on.
    Live,
    /// Recordings.
    Recording,
    /// A session of a study.
    Study,
}

impl Page {
    /// Texts of the playground's page that this page replaces, with the replacements.
    const fn otherwise(self) -> &'static [(&'static str, &'static str)] {
        const BODY: &str = "<body>";
        const TITLE: &str = "<title>Palpate: touch it</title>";
        const SCRIPT: &str = "import \"palpate/main.js\"";
        match self {
            Self::Live => &[
                (BODY, "<body class=\"live\">"),
                (TITLE, "<title>Palpate: live</title>"),
                (SCRIPT, "import \"palpate/live.js\""),
            ],
            Self::Study => &[],
            Self::Recording => &[
                (BODY, "<body class=\"recorded\">"),
                (TITLE, "<title>Palpate: recording</title>"),
                (SCRIPT, "import \"palpate/recording.js\""),
            ],
        }
    }

    /// Sources that the page may connect to: this host alone. Two recordings are two frames of the same page.
    fn connects(self, host: &str) -> String {
        let frames = match self {
            Self::Live | Self::Study => "",
            Self::Recording => "; frame-src 'self'",
        };
        format!("connect-src 'self' ws://{host}{frames}")
    }
}

/// The file of a page at a path.
pub(super) fn file(path: &str, page: Page) -> Option<&'static PageFile> {
    let files = match page {
        Page::Study => &STUDY[..],
        Page::Live | Page::Recording => &FILES[..],
    };
    files.iter().find(|file| file.path == path)
}

impl PageFile {
    /// Text of the file for a page at this host's name, which may open a socket there and nowhere else. Where a socket
    /// needs a token, the page knows why it has none.
    pub(super) fn text(&self, host: &str, page: Page, wants_token: bool) -> String {
        if self.media_type != HTML {
            return self.text.to_owned();
        }
        let connects = page.connects(host);
        let own = [("connect-src 'self'", connects.as_str())];
        let token = wants_token.then_some(("<body", "<body data-token"));
        let changes = page.otherwise().iter().copied().chain(own).chain(token);
        changes.fold(self.text.to_owned(), |text, (what, instead)| {
            text.replacen(what, instead, 1)
        })
    }
}

/// The page in a notebook: the playground's, and the names and texts of the scripts that it loads.
#[must_use]
pub fn notebook() -> (String, Vec<(&'static str, &'static str)>) {
    let text = |path| FILES.iter().find(|file| file.path == path);
    let text = |path| text(path).map_or("", |file| file.text);
    let style = format!("<style>{}</style>", text("/style.css"));
    let changes = [
        ("<body>", "<body class=\"notebook\">"),
        ("<link rel=\"stylesheet\" href=\"style.css\">", &style),
        (
            "import \"palpate/main.js\"",
            "import \"palpate/notebook.js\"",
        ),
        ("script-src 'self'", "script-src data:"),
    ];
    let page = changes
        .iter()
        .fold(text("/").to_owned(), |page, (what, instead)| {
            page.replacen(what, instead, 1)
        });
    let loaded = [
        "draw.js",
        "finger.js",
        "limits.js",
        "pad.js",
        "panels.js",
        "plots.js",
    ];
    let own = ("notebook.js", NOTEBOOK.text);
    let scripts = FILES.iter().filter_map(|file| {
        let name = file.path.strip_prefix('/')?;
        loaded.contains(&name).then_some((name, file.text))
    });
    (page, scripts.chain([own]).collect())
}

#[cfg(test)]
#[path = "files_tests.rs"]
mod tests;
