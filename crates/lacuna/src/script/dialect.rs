//! How scripts are read. Two things differ from plain rhai.
//!
//! A comparison means "must hold" in a list of rules and "which way" after `if` and `while`; the tokens tell
//! these apart, so they become different operators. Both are ours alone: rhai itself would answer a
//! comparison that it does not know with a silent `false`, and the rule would be lost.
//!
//! `with` is an ordinary name here.

use std::collections::{BTreeMap, BTreeSet};

use rhai::{Position, Token};

use super::graph::Spot;
use super::tracer::spot;

/// Comparison operators: as written, as a statement, as a question.
pub(super) const COMPARISONS: [(&str, &str, &str); 6] = [
    ("<", "must be <", "is <"),
    ("<=", "must be <=", "is <="),
    (">", "must be >", "is >"),
    (">=", "must be >=", "is >="),
    ("==", "must be ==", "is =="),
    ("!=", "must be !=", "is !="),
];

/// Precedence of `<` and of `==` in rhai's own table.
pub(super) const PRECEDENCES: [u8; 6] = [130, 130, 130, 130, 90, 90];

/// A function of the script.
#[derive(Debug, Clone, Default)]
pub(super) struct Defined {
    pub(super) spot: Spot,
    pub(super) arguments: Vec<String>,
}

/// What the tokens say about a script, and where in it the reader is.
#[derive(Debug, Default)]
pub(super) struct Dialect {
    /// Open brackets since the last `if` or `while`; `None` outside a condition.
    condition: Option<usize>,
    state: State,
    /// Functions by name.
    pub(super) functions: BTreeMap<String, Defined>,
    /// Where loops begin and where functions call themselves: what may go on without end.
    pub(super) repeats: Vec<Spot>,
    /// The function that is being read.
    inside: String,
    /// Every name in the script.
    pub(super) mentions: BTreeSet<String>,
    /// Names that `let`, `const` and `for` introduce.
    pub(super) variables: Vec<String>,
}

#[derive(Debug, Default)]
enum State {
    #[default]
    Elsewhere,
    /// After `fn`.
    Function,
    /// Between the name and the closing bracket.
    Arguments(String),
    /// After `let`, `const`, `for`.
    Variable,
}

impl Dialect {
    /// What the parser gets to see for a token.
    pub(super) fn read(&mut self, token: Token, position: Position) -> Token {
        let token = match token {
            Token::Reserved(word) if *word == "with" => Token::Identifier(word),
            other => other,
        };
        self.note(&token, position);
        self.follow(&token);
        self.compare(token)
    }

    fn compare(&self, token: Token) -> Token {
        let place = match token {
            Token::LessThan => 0,
            Token::LessThanEqualsTo => 1,
            Token::GreaterThan => 2,
            Token::GreaterThanEqualsTo => 3,
            Token::EqualsTo => 4,
            Token::NotEqualsTo => 5,
            other => return other,
        };
        let (_, statement, question) = COMPARISONS[place];
        let name = if self.condition.is_some() { question } else { statement };
        Token::Custom(Box::new(name.into()))
    }

    /// Keeps track of conditions: they end where their block begins.
    fn follow(&mut self, token: &Token) {
        match (token, self.condition) {
            (Token::If | Token::While | Token::Until, _) => self.condition = Some(0),
            (Token::LeftBrace | Token::SemiColon, Some(0)) => self.condition = None,
            (Token::LeftParen | Token::LeftBracket | Token::LeftBrace | Token::MapStart, Some(open)) => {
                self.condition = Some(open + 1);
            }
            (Token::RightParen | Token::RightBracket | Token::RightBrace, Some(open)) => {
                self.condition = open.checked_sub(1);
            }
            _ => {}
        }
    }

    /// Keeps the names that the script defines, for error messages.
    fn note(&mut self, token: &Token, position: Position) {
        if matches!(token, Token::Loop | Token::While | Token::Do | Token::For) {
            self.repeats.push(spot(position));
        }
        if let Token::Identifier(name) = token {
            self.mentions.insert(name.to_string());
            if **name == self.inside {
                self.repeats.push(spot(position));
            }
        }
        let state = std::mem::take(&mut self.state);
        self.state = match (state, token) {
            (_, Token::Fn) => State::Function,
            (_, Token::Let | Token::Const | Token::For) => State::Variable,
            (State::Function, Token::Identifier(name)) => {
                let defined = Defined { spot: spot(position), arguments: Vec::new() };
                self.functions.insert(name.to_string(), defined);
                self.inside = name.to_string();
                State::Arguments(name.to_string())
            }
            // `()` is one token.
            (State::Arguments(_), Token::RightParen | Token::Unit) => State::Elsewhere,
            (State::Arguments(function), Token::Identifier(name)) => {
                if let Some(defined) = self.functions.get_mut(&function) {
                    defined.arguments.push(name.to_string());
                }
                State::Arguments(function)
            }
            (State::Arguments(function), _) => State::Arguments(function),
            (State::Variable, Token::Identifier(name)) => {
                self.variables.push(name.to_string());
                State::Elsewhere
            }
            (State::Variable, Token::LeftParen) => State::Variable,
            _ => State::Elsewhere,
        };
    }
}
